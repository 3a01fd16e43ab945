"""Notes of a setup between its runs: the answers, and the files of its folder."""

import shutil
from dataclasses import dataclass
from pathlib import Path

import msgspec

from common.atomic_file import OWNER_ONLY
from common.cameras.settings import AS_IT_IS, CameraSettings
from common.cameras.shown_source import hides_part
from common.errors import ConfigError
from farhand.outputs import write_result
from local_site.calibration.control_points import CAMERAS

NAMES = CAMERAS[:2]


class SetupAnswers(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The answers so far; None where a question has not been answered yet.

    `square_mm` is the printed board's square as measured; `standing` whether the first board stood upright;
    `pairs_by` and `rig_by` are what pairs and rig were made with, as `pairs_need` and `rig_needs` describe it.
    """

    left: str | None = None
    right: str | None = None
    cameras: CameraSettings | None = None
    square_mm: float | None = None
    standing: bool = False
    method: str | None = None
    right_arm: bool = True
    pairs_by: str | None = None
    rig_by: str | None = None

    @property
    def sources(self) -> dict[str, str]:
        """The cameras by their names in the rig; empty until both are known."""
        return {} if self.left is None or self.right is None else dict(zip(NAMES, (self.left, self.right), strict=True))

    @property
    def settings(self) -> CameraSettings:
        """The settings of the cameras."""
        return self.cameras or AS_IT_IS

    @property
    def pairs_need(self) -> str:
        """The conditions of the pairs of pictures: the cameras and their size."""
        return f"left {self.left}, right {self.right}, {self.settings.size_px}"

    @property
    def rig_needs(self) -> str:
        """The conditions of the rig: its pairs, the board's squares and how the first board was placed."""
        return f"{self.pairs_need}, squares of {self.square_mm} mm, standing {self.standing}"


@dataclass(frozen=True, slots=True)
class SetupFolder:
    """The folder with all that a setup makes."""

    path: Path

    @property
    def board(self) -> Path:
        """The page to print."""
        return self.path / "board.pdf"

    @property
    def thumbnails(self) -> Path:
        """The folder with a small picture of each camera."""
        return self.path / "thumbnails"

    @property
    def rig(self) -> Path:
        """The calibration."""
        return self.path / "rig.json"

    @property
    def configuration(self) -> Path:
        """The local site's configuration."""
        return self.path / "local.toml"

    def pictures(self, name: str) -> Path:
        """The folder with a camera's calibration pictures."""
        return self.path / "calibration" / name

    def answers(self) -> SetupAnswers:
        """The answers of earlier runs; ConfigError if their file is damaged."""
        path = self._answers
        try:
            return msgspec.json.decode(path.read_bytes(), type=SetupAnswers)
        except FileNotFoundError:
            return SetupAnswers()
        except (OSError, ValueError) as error:
            raise ConfigError(f"{path} cannot be used ({error}); remove it, and answer the questions again") from error

    def keep(self, answers: SetupAnswers) -> SetupAnswers:
        """Write the answers, for their owner alone, since a camera's URL may hold a password; return them."""
        content = msgspec.json.format(msgspec.json.encode(answers), indent=2) + b"\n"
        write_result(self._answers, content, OWNER_ONLY)
        return answers

    def configure(self, text: bytes) -> None:
        """Write the configuration, for its owner alone where it may hold a camera's password."""
        has_secret = any(map(hides_part, self.answers().sources.values()))
        write_result(self.configuration, text, OWNER_ONLY if has_secret else None)

    def put_configuration_aside(self) -> None:
        """Rename the configuration to local.toml.old, for its owner alone: its cameras may be others."""
        self.configuration.chmod(OWNER_ONLY)
        self.configuration.rename(self.path / f"{self.configuration.name}.old")

    def put_pairs_aside(self) -> None:
        """Rename the folder of calibration pictures to calibration.old, in place of one that is there."""
        pairs, old = self.path / "calibration", self.path / "calibration.old"
        if pairs.exists():
            shutil.rmtree(old, ignore_errors=True)
            pairs.rename(old)

    @property
    def _answers(self) -> Path:
        return self.path / "answers.json"
