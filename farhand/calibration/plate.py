"""Calibration from pictures of a plate of discs at known heights."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from common.cameras.camera import Image
from common.errors import CalibrationError, ConfigError
from farhand.calibration.pictures import PictureJob, read_pictures, write_coverage, write_found
from farhand.calibration.points import Calibrated, calibrate_control
from local_site.calibration.plate import Plate, PlateView, plate_control_points, view_plate, without_perspective_bias
from local_site.calibration.solve import solve_rig


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
