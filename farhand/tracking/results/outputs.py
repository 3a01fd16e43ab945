"""Outputs of a track: checked before any work, and opened as results that take its pairs."""

import csv
import io
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import msgspec

from common.cameras.images import write_image
from common.errors import ConfigError
from farhand.outputs import check_file, check_folder, refuse_shared, written_at_end
from farhand.reports.plotting import require_matplotlib
from farhand.tracking.results.report.origin import Rows
from farhand.tracking.results.report.track_report import PAGE, track_report
from farhand.tracking.results.tracked_pair import Result, Take, TrackedPair
from farhand.tracking.results.video import SUFFIX, check_video, overlay_video
from farhand.tracking.track_line import ALL_POINTS, POINTS

COLUMNS = (
    *("frame", "t_s", "status", "reason"),
    *(f"{name}_{axis}_m" for name in ALL_POINTS for axis in "xyz"),
    *(f"{name}_sigma_m" for name in POINTS),
    *("thumb_inferred", "hand_open", "gripper_toggles", "residual_px", "tracking_ms"),
)
NOWHERE = (None, None, None)


@contextmanager
def json_lines(out: Path) -> Iterator[Take]:
    """A file with a line of JSON for each pair; an earlier one stays until there is a line."""
    with written_at_end(out) as lines:
        yield lambda pair: lines.write(msgspec.json.encode(pair.line).decode() + "\n")


@contextmanager
def csv_rows(out: Path) -> Iterator[Take]:
    """A file with a row for each pair below the names of the columns; an earlier one stays until there is a row."""
    with written_at_end(out) as lines:
        yield lambda pair: lines.write(_text(*([COLUMNS] if pair.line.frame == 0 else []), _row(pair)))


def _text(*rows: tuple[object, ...]) -> str:
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows(rows)
    return text.getvalue()


def _row(pair: TrackedPair) -> tuple[object, ...]:
    """The cells of a pair; None becomes an empty one."""
    line = pair.line
    points = (coordinate for name in ALL_POINTS for coordinate in getattr(line, name) or NOWHERE)
    sigmas = (line.sigma[name] for name in POINTS)
    flags = (str(flag).lower() for flag in (line.thumb_inferred, line.hand_open))
    ends = line.gripper_toggles, line.residual_px, line.ms
    return line.frame, round(pair.t_s, 6), line.status.value, line.reason, *points, *sigmas, *flags, *ends


@contextmanager
def annotated_pictures(folder: Path) -> Iterator[Take]:
    """A folder with NUMBER.png for each pair, made with the first."""
    yield lambda pair: write_image(folder, f"{pair.line.frame:06d}", pair.picture)


@dataclass(frozen=True, slots=True)
class TrackOutputs:
    """The outputs of a track: `out` (JSON lines), and what else is asked for.

    `annotate` is a folder for pictures of all pairs, `video` a file for them, `report` a folder, `csv` a file.
    """

    out: Path
    annotate: Path | None = None
    video: Path | None = None
    report: Path | None = None
    csv: Path | None = None

    def check(self, inputs: Sequence[str | Path]) -> None:
        """Before any work, ConfigError for what cannot be written, FarhandError for a report without matplotlib."""
        for option, file in (("--out", self.out), ("--csv", self.csv), ("--video", self.video)):
            if file is not None:
                check_file(option, file, inputs)
        if self.video is not None and self.video.suffix.lower() != SUFFIX:
            raise ConfigError(f"--video {self.video}: give a name that ends in {SUFFIX}, as overlay{SUFFIX}")
        self._check_folders(inputs)
        named = {"--annotate": self.annotate, "--video": self.video, "--report": self.report, "--csv": self.csv}
        refuse_shared({"--out": self.out, **named})
        if self.report is not None:
            require_matplotlib()

    def _check_folders(self, inputs: Sequence[str | Path]) -> None:
        if _is_file_name(self.annotate):
            raise ConfigError(
                f"--annotate {self.annotate} looks like a file, but is a folder for pictures; "
                f"for a video give --video {Path(self.annotate).with_suffix(SUFFIX) if self.annotate else ''}"
            )
        if _is_file_name(self.report):
            raise ConfigError(f"--report {self.report} looks like a file; give a folder, in which {PAGE} will be")
        check_folder("--annotate", self.annotate, inputs)
        check_folder("--report", self.report, inputs)

    def check_rate(self, fps: float | None) -> None:
        """ConfigError, before any work, if no video of the recording's rate (Hz) can be written."""
        if self.video is not None:
            check_video("--video", self.video, fps)

    def results(self, fps: float | None, origin: Rows) -> list[Result]:
        """Return what takes the pairs of a recording of this rate (Hz); nothing is written before it is entered.

        `origin` says, for the report, what the track was made of.
        """
        chosen: list[Result] = []
        if self.video is not None and fps is not None:
            chosen.append(overlay_video(self.video, fps))  # first, as it may refuse the first picture
        chosen.append(json_lines(self.out))
        if self.csv is not None:
            chosen.append(csv_rows(self.csv))
        if self.annotate is not None:
            chosen.append(annotated_pictures(self.annotate))
        if self.report is not None:
            chosen.append(track_report(self.report, origin))
        return chosen

    @property
    def written(self) -> list[Path]:
        """All that a track writes, as a person looks for it."""
        report = self.report and self.report / PAGE
        return [path for path in (self.out, self.csv, self.video, report, self.annotate) if path is not None]


def _is_file_name(folder: Path | None) -> bool:
    """Return whether what should become a folder has a name like overlay.mp4."""
    return folder is not None and folder.suffix[1:2].isalpha() and not folder.is_dir()
