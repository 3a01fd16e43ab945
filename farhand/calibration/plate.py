"""Calibration from pictures of a plate of discs at known heights."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from common.cameras.camera import Image
from common.errors import CalibrationError, ConfigError
from farhand.calibration.pictures import read_pictures
from farhand.calibration.points import Calibrated, calibrate_control
from local_site.calibration.coverage import coverage_map, draw_found
from local_site.calibration.plate import (
    Plate,
    PlateView,
    plate_control_points,
    view_plate,
    without_perspective_bias,
)
from local_site.calibration.solve import solve_rig
from local_site.preview.picture_files import write_picture


@dataclass(frozen=True, slots=True)
class PlateJob:
    """The plate, its heights in m, the cameras' pictures by name, and where results go."""

    plate: Plate
    heights: tuple[float, ...]
    sources: Mapping[str, str]
    out: Path
    pictures: Path | None = None


def parse_heights(text: str) -> tuple[float, ...]:
    """Heights in m from '0,497,994' in mm; ConfigError if they are not two or more different numbers."""
    try:
        heights = tuple(float(part) / 1000 for part in text.split(","))
    except ValueError:
        heights = ()
    if len(set(heights)) < 2 or len(set(heights)) < len(heights) or not np.all(np.isfinite(heights)):
        raise ConfigError(f"--heights-mm must be two or more different numbers such as 0,497,994, not {text!r}")
    return heights


def calibrate_plate(job: PlateJob, serials: Sequence[str] = ()) -> Calibrated:
    """Find the discs, solve the rig, correct the discs' perspective bias, and solve again."""
    pictures = {name: read_pictures(source, name) for name, source in job.sources.items()}
    for name, own in pictures.items():
        if len(own) != len(job.heights):
            raise CalibrationError(
                f"camera {name}: {len(own)} pictures for {len(job.heights)} heights; give one picture for each of "
                "--heights-mm, in the same order; for a printed board, give --board charuco or --board chessboard"
            )
    views = {
        name: [view_plate(picture, job.plate, f"{name} picture {k + 1}") for k, picture in enumerate(own)]
        for name, own in pictures.items()
    }
    if job.pictures is not None:
        _write(job.pictures, pictures, views)
    control = plate_control_points(list(views.values()), job.heights, job.plate)
    rough = solve_rig(control, created="")
    return calibrate_control(without_perspective_bias(control, rough.matrices, job.plate.diameter), job.out, serials)


def _write(folder: Path, pictures: Mapping[str, Sequence[Image]], views: Mapping[str, Sequence[PlateView]]) -> None:
    for name, own in views.items():
        for k, (picture, view) in enumerate(zip(pictures[name], own, strict=True)):
            order = np.lexsort(view.lattice.cells.T)
            begin = view.beginnings[0] if len(view.beginnings) == 1 else (0, 0)
            names = [f"{i + 1},{j + 1}" for i, j in (view.lattice.cells[order] + begin).tolist()]
            write_picture(folder, f"{name}_{k + 1}", draw_found(picture, view.lattice.pixels[order], names))
        pixels = np.concatenate([view.lattice.pixels for view in own])
        write_picture(folder, f"{name}_coverage", coverage_map(pixels, own[0].size_px, pictures[name][-1]))
