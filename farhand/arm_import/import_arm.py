"""`farhand arm import`: a URDF read, an arm designed, its URDF and configuration written and checked."""

import tempfile
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path

from common.config.loading import load_config
from common.errors import ModelError
from farhand.arm_import.choices.posture import Direction
from farhand.arm_import.description.arm import ChosenArm, check_joints, choose_arm
from farhand.arm_import.description.elements import with_free_names
from farhand.arm_import.description.packages import Packages
from farhand.arm_import.description.reading import read_description
from farhand.arm_import.design import Design, LoadedArm, design, tool_capsules, tool_T_tcp
from farhand.arm_import.files import Places, read_urdf
from farhand.arm_import.prepared import PreparedArm, cover_links, prepare
from farhand.arm_import.writing.manifest import with_manifest
from farhand.arm_import.writing.summary import Written, changes, summary
from farhand.arm_import.writing.toml import toml_text
from farhand.arm_import.writing.urdf import gather_meshes, urdf_text
from farhand.deployment.schemas import add_schema, schema_line
from farhand.terminal import ShowProgress
from remote_site.config import RemoteConfig
from remote_site.kinematics.model import ArmModel
from remote_site.runtime.checks import find_mistakes
from remote_site.safety.collision import CollisionModel
from remote_site.simulation.config import NAMES


@dataclass(frozen=True, slots=True)
class ImportRequest:
    """The arm to import into `out`, a TOML file, and what the user says of it."""

    urdf: Path
    out: Path
    tool: str | None = None
    base: str | None = None
    points: Direction | None = None
    packages: Mapping[str, Path] = field(default_factory=dict)
    search: Sequence[Path] = ()
    positions: Mapping[str, float] = field(default_factory=dict)
    jerk: float | None = None


def import_arm(request: ImportRequest, show: ShowProgress) -> list[str]:
    """Write all files, and return what was done as lines; ModelError or ConfigError name what stands against it."""
    places, source = Places.around(request.out, request.urdf), str(request.urdf)
    if request.urdf.is_dir():  # before the name of what is written, which comes of it, is found wrong
        raise ModelError(f"{request.urdf} is a folder; give the path of a URDF file")
    places.check(request.urdf)
    robot = with_free_names(read_description(read_urdf(request.urdf), source), NAMES)
    arm = choose_arm(robot, request.tool, request.base, request.positions)
    check_joints(arm)
    found = _design(arm, request, show)
    contents = _contents(found, source, places)
    _check(contents, places)
    places.write(contents)
    add_schema(RemoteConfig, places.toml)
    sizes = [len(content) for name, content in contents.items() if name.startswith(f"{places.meshes.name}/")]
    written = Written(str(places.toml), str(places.urdf), str(places.meshes), len(sizes), sum(sizes))
    return summary(found, source, written)


def _contents(found: Design, source: str, places: Places) -> dict[str, bytes]:
    """Every file by its name as seen from the configuration, which is the last of them."""
    head = [f"The arm of {source}, imported by farhand arm import. What differs, and what was assumed:", ""]
    lines = [*head, *changes(found)]
    robot, files = gather_meshes(found.prepared.robot, places.meshes.name)
    meshes = {name: file.read_bytes() for name, file in files.items()}
    beside = [f"Its meshes are in {places.meshes.name}, beside this file: copy them with it."] if meshes else []
    urdf = urdf_text(robot, [*lines, "", *beside]).encode()
    keys = "Every key that there is: farhand config show remote"
    toml = f"{schema_line(RemoteConfig)}\n{toml_text(found, places.urdf.name, [*lines, '', keys])}".encode()
    name = places.urdf.name
    return {**meshes, name: with_manifest(urdf, name, {places.toml.name: toml, **meshes}), places.toml.name: toml}


def _design(arm: ChosenArm, request: ImportRequest, show: ShowProgress) -> Design:
    find = Packages(request.urdf.resolve().parent, request.packages, request.search).find
    covered = cover_links(arm, find, show)

    def prepared(hulls: Collection[str], turned: bool) -> PreparedArm:
        return prepare(arm, covered, find, hulls, turned=turned, jerk=request.jerk)

    with tempfile.TemporaryDirectory(prefix="farhand-") as folder:
        written = Path(folder) / "arm.urdf"
        try:
            return design(prepared, partial(_load, written), request.points, show, jerk_given=request.jerk is not None)
        except ModelError as error:  # of what the maker's file has become
            raise ModelError(str(error).replace(str(written), str(request.urdf))) from error


def _load(path: Path, prepared: PreparedArm) -> LoadedArm:
    """The arm as the remote site reads it, by way of a file."""
    path.write_text(urdf_text(prepared.robot, []))
    model, capsules = ArmModel.from_urdf(path, prepared.tool.frame, tool_T_tcp()), tool_capsules(prepared)
    return LoadedArm(model, lambda config: CollisionModel.from_urdf(path, model, capsules, config))


def _check(contents: Mapping[str, bytes], places: Places) -> None:
    """ModelError where the remote site would not start with what is written, wherever it is moved."""
    with tempfile.TemporaryDirectory(prefix="farhand-") as folder:
        tried = places.within(Path(folder))
        tried.write(contents)
        mistakes = find_mistakes(load_config(RemoteConfig, tried.toml))
    if mistakes:
        said = "\n".join(mistake.sentence.replace(f"{folder}/", "") for mistake in mistakes)
        raise ModelError(
            f"{said}\nnothing was written: write it by hand, as docs/another-arm.md shows, or correct the URDF"
        )
