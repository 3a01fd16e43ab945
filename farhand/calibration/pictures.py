"""Pictures for a calibration, read and written, and the calibration from those of a plate of discs at known heights."""

import glob
from collections.abc import Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass, field
from pathlib import Path

import cv2
import numpy as np

from common.cameras.camera import Image
from common.cameras.images import IMAGE_SUFFIXES, write_image
from common.cameras.shown_source import shown_source
from common.cameras.sources import damage_of, open_camera
from common.errors import CalibrationError, CameraError, ConfigError
from common.geometry import Array
from farhand.calibration.cameras import CameraSetup
from farhand.calibration.points import Calibrated, calibrate_control
from local_site.acquisition.same_source import refuse_same
from local_site.calibration.control_points import CAMERAS
from local_site.calibration.coverage import coverage_map, draw_found
from local_site.calibration.plate import Plate, PlateView, plate_control_points, view_plate, without_perspective_bias
from local_site.calibration.solve import solve_rig

MAX_PICTURES = 500


@dataclass(frozen=True, slots=True)
class PictureJob:
    """The cameras' sources by name, the rig file to write, a folder for found pictures, serial numbers NAME=NUMBER.

    `setup` is that of running cameras.
    """

    sources: Mapping[str, str]
    out: Path
    pictures: Path | None = None
    serials: Sequence[str] = ()
    setup: CameraSetup = field(default_factory=CameraSetup)


def by_name(sources: Sequence[str | None]) -> dict[str, str]:
    """The sources that were given, by their cameras' names; ConfigError if one was left out, or given twice."""
    present = [source for source in sources if source is not None]
    if list(sources[: len(present)]) != present:
        raise ConfigError("a camera was left out; give them in this order: --left, --right, --third, --fourth")
    named = dict(zip(CAMERAS, present, strict=False))
    refuse_same(named)
    return named


def read_pictures(source: str, name: str) -> list[Image]:
    """All pictures of a folder, a pattern such as 'left_*.png', a file or a video, in the order of their names."""
    paths = [Path(path) for path in sorted(glob.glob(source))] if glob.has_magic(source) else [Path(source)]
    if paths and all(path.is_file() and path.suffix.lower() in IMAGE_SUFFIXES for path in paths):
        return [_read(path, name) for path in paths[:MAX_PICTURES]]
    if not paths:
        raise CameraError(
            f"camera {name}: no file matches {shown_source(source)}; put the pattern in quotes and check the folder"
        )
    if not paths[0].exists():
        raise CameraError(
            f"camera {name}: {shown_source(source)} does not exist; give a folder of pictures, a pattern or a video"
        )
    pictures: list[Image] = []
    with closing(open_camera(source, name)) as camera:
        while len(pictures) < MAX_PICTURES and (frame := camera.read()) is not None:
            pictures.append(frame.image)
    if damage := damage_of(camera):
        raise CameraError(damage)
    return pictures


def _read(path: Path, name: str) -> Image:
    picture = cv2.imread(str(path), cv2.IMREAD_COLOR)
    if picture is None:
        raise CameraError(f"camera {name}: {path} is not an image that can be read; remove or replace it")
    return np.asarray(picture, dtype=np.uint8)


def write_found(folder: Path, name: str, number: int, picture: Image, found: tuple[Array, Sequence[str]]) -> None:
    """Write a camera's picture of this number with what was found in it: pixels (N, 2) and their names."""
    write_image(folder, f"{name}_{number}", draw_found(picture, *found))


def write_coverage(folder: Path, name: str, picture: Image, pixels: Array) -> None:
    """Write which parts of a camera's picture all its pixels (N, 2) cover."""
    write_image(folder, f"{name}_coverage", coverage_map(pixels, size_of(picture), picture))


def size_of(picture: Image) -> tuple[int, int]:
    """Width and height, px."""
    return picture.shape[1], picture.shape[0]


def parse_heights(text: str) -> tuple[float, ...]:
    """Heights in m from '0,497,994' in mm; ConfigError if they are not two or more different numbers."""
    try:
        heights = tuple(float(part) / 1000 for part in text.split(","))
    except ValueError:
        heights = ()
    if len(set(heights)) < 2 or len(set(heights)) < len(heights) or not np.all(np.isfinite(heights)):
        raise ConfigError(f"--heights-mm must be two or more different numbers such as 0,497,994, not {text!r}")
    return heights


def calibrate_plate(job: PictureJob, plate: Plate, heights: tuple[float, ...]) -> Calibrated:
    """Find the discs at all heights (m), solve the rig, correct the discs' perspective bias, and solve again."""
    pictures = {name: read_pictures(source, name) for name, source in job.sources.items()}
    for name, own in pictures.items():
        if len(own) != len(heights):
            raise CalibrationError(
                f"camera {name}: {len(own)} pictures for {len(heights)} heights; give one picture for each of "
                "--heights-mm, in the same order; for a printed board, give --board charuco or --board chessboard"
            )
    views = {
        name: [view_plate(picture, plate, f"{name} picture {k + 1}") for k, picture in enumerate(own)]
        for name, own in pictures.items()
    }
    if job.pictures is not None:
        for name, seen in views.items():
            _write_seen(job.pictures, name, pictures[name], seen)
    control = plate_control_points(list(views.values()), heights, plate)
    rough = solve_rig(control, created="")
    return calibrate_control(without_perspective_bias(control, rough.matrices, plate.diameter), job.out, job.serials)


def _write_seen(folder: Path, name: str, pictures: Sequence[Image], views: Sequence[PlateView]) -> None:
    for k, (picture, view) in enumerate(zip(pictures, views, strict=True)):
        order = np.lexsort(view.lattice.cells.T)
        begin = view.beginnings[0] if len(view.beginnings) == 1 else (0, 0)
        cells = [f"{i + 1},{j + 1}" for i, j in (view.lattice.cells[order] + begin).tolist()]
        write_found(folder, name, k + 1, picture, (view.lattice.pixels[order], cells))
    write_coverage(folder, name, pictures[-1], np.concatenate([view.lattice.pixels for view in views]))
