"""`farhand arm import`: a URDF read, an arm designed, its URDF and configuration written and checked."""

import tempfile
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path

from common.atomic_file import write_atomically
from common.config import load_config
from common.errors import ConfigError, ModelError
from farhand.arm_import.choices.posture import Direction
from farhand.arm_import.description.arm import ChosenArm, choose_arm
from farhand.arm_import.description.elements import with_free_names
from farhand.arm_import.description.packages import Packages
from farhand.arm_import.description.reading import read_description
from farhand.arm_import.design import Design, LoadedArm, design, tool_capsules, tool_T_tcp
from farhand.arm_import.prepared import PreparedArm, cover_links, prepare
from farhand.arm_import.writing.summary import changes, summary
from farhand.arm_import.writing.toml import toml_text
from farhand.arm_import.writing.urdf import urdf_text
from farhand.outputs import check_file
from remote_site.config import RemoteConfig
from remote_site.kinematics.model import ArmModel
from remote_site.runtime.checks import find_mistakes
from remote_site.safety.collision import CollisionModel
from remote_site.simulation.config import NAMES


@dataclass(frozen=True, slots=True)
class ImportRequest:
    """What is imported into `out`, a TOML file, and what the user says of it."""

    urdf: Path
    out: Path
    tool: str | None = None
    base: str | None = None
    points: Direction | None = None
    packages: Mapping[str, Path] = field(default_factory=dict)
    search: Sequence[Path] = ()
    positions: Mapping[str, float] = field(default_factory=dict)
    jerk: float | None = None

    @property
    def out_urdf(self) -> Path:
        """The arm's file, beside the configuration; where that is the maker's own file, one of another name."""
        beside = self.out.with_suffix(".urdf")
        return beside if beside.resolve() != self.urdf.resolve() else self.out.with_name(f"{self.out.stem}-arm.urdf")


def import_arm(request: ImportRequest) -> list[str]:
    """Write both files, and return what was done as lines; ModelError or ConfigError name what stands against it."""
    _check_outputs(request)
    source = str(request.urdf)
    robot = with_free_names(read_description(_read(request.urdf), source), NAMES)
    arm = choose_arm(robot, request.tool, request.base, request.positions)
    found = _design(arm, request)
    head = [f"The arm of {source}, imported by farhand arm import. What differs, and what was assumed:", ""]
    lines = [*head, *changes(found)]
    urdf = urdf_text(
        found.prepared.robot, [*lines, "", "Meshes are named where they were found: import again after moving them."]
    )
    toml = toml_text(found, request.out_urdf.name, [*lines, "", "Every key that there is: farhand config show remote"])
    _check(urdf, toml, request)
    write_atomically(request.out_urdf, urdf.encode())
    write_atomically(request.out, toml.encode())
    return summary(found, source, str(request.out_urdf), str(request.out))


def _check_outputs(request: ImportRequest) -> None:
    if request.out.suffix != ".toml":
        raise ConfigError(f"--out {request.out}: give a file that ends in .toml")
    for out in (request.out, request.out_urdf):
        check_file("--out", out, [request.urdf])
        if out.exists():
            raise ConfigError(f"--out: {out} exists already; give another name, or remove it first")


def _read(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except OSError as error:
        raise ModelError(f"cannot read {path}: {error.strerror}; give the path of a URDF file") from error


def _design(arm: ChosenArm, request: ImportRequest) -> Design:
    find = Packages(request.urdf.resolve().parent, request.packages, request.search).find
    covered = cover_links(arm, find)

    def prepared(hulls: Collection[str], turned: bool) -> PreparedArm:
        return prepare(arm, covered, find, hulls, turned=turned, jerk=request.jerk)

    with tempfile.TemporaryDirectory(prefix="farhand-") as folder:
        return design(
            prepared, partial(_load, Path(folder) / "arm.urdf"), request.points, jerk_given=request.jerk is not None
        )


def _load(path: Path, prepared: PreparedArm) -> LoadedArm:
    """The arm as the remote site reads it, by way of a file."""
    path.write_text(urdf_text(prepared.robot, []))
    model, capsules = ArmModel.from_urdf(path, prepared.tool.frame, tool_T_tcp()), tool_capsules(prepared)
    return LoadedArm(model, lambda config: CollisionModel.from_urdf(path, model, capsules, config))


def _check(urdf: str, toml: str, request: ImportRequest) -> None:
    """ModelError where the remote site would not start with what is written."""
    with tempfile.TemporaryDirectory(prefix="farhand-") as folder:
        out = Path(folder) / request.out.name
        out.write_text(toml, encoding="utf-8")
        (Path(folder) / request.out_urdf.name).write_text(urdf, encoding="utf-8")
        mistakes = find_mistakes(load_config(RemoteConfig, out))
    if mistakes:
        raise ModelError("\n".join(f"{mistake.sentence}; {mistake.cure}" for mistake in mistakes))
