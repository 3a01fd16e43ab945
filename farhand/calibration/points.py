"""Calibration from control points: a CSV file in, a rig file out, and a summary for people."""

import math
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from msgspec.structs import replace

from common.errors import CalibrationError, ConfigError
from local_site.calibration.checks import odd_orientation
from local_site.calibration.control_points import ControlPoints, Size, read_control_points
from local_site.calibration.coverage import coverage_warnings
from local_site.calibration.physical_camera import decomposed
from local_site.calibration.rig import CameraCalibration, Rig, Vector3
from local_site.calibration.rig_file import save_rig
from local_site.calibration.solve import solve_rig

MAX_PICTURE_PX = 100_000
USUAL_RMS_PX = 1.0
USUAL_STRETCH = 0.03
USUAL_SPAN_M = (0.05, 20.0)


@dataclass(frozen=True, slots=True)
class Calibrated:
    """A new rig, where it was written, and warnings."""

    rig: Rig
    out: Path
    warnings: tuple[str, ...] = ()


def calibrate_points(csv: Path, out: Path, size: Size | None = None, serials: Sequence[str] = ()) -> Calibrated:
    """Solve the rig of a control point file and write it; CalibrationError names every mistake of the file."""
    return calibrate_control(read_control_points(csv, size), out, serials)


def calibrate_control(control: ControlPoints, out: Path, serials: Sequence[str] = ()) -> Calibrated:
    """Solve the rig of control points and write it."""
    return write_rig(solve_rig(control, created=now()), control, out, serials)


def write_rig(rig: Rig, control: ControlPoints, out: Path, serials: Sequence[str]) -> Calibrated:
    """Write the rig of control points with its cameras' serial numbers, each given as NAME=NUMBER.

    ConfigError names an unknown camera.
    """
    pairs = dict(text.partition("=")[::2] for text in serials)
    names = [camera.name for camera in rig.cameras]
    if not all(pairs.values()) or not set(pairs) <= set(names):
        raise ConfigError(f"--serial must be NAME=NUMBER with NAME one of {', '.join(names)}")
    cameras = tuple(replace(camera, serial=pairs.get(camera.name, "")) for camera in rig.cameras)
    rig = replace(rig, cameras=cameras)
    save_rig(rig, out)
    return Calibrated(rig, out, coverage_warnings(control))


@contextmanager
def solvable() -> Iterator[None]:
    """Turn a system of equations without a solution into a CalibrationError with its cure."""
    try:
        yield
    except (np.linalg.LinAlgError, cv2.error) as error:
        cure = "give every camera pictures or pixels of its own, and check the plate's size, pitch and heights"
        raise CalibrationError(f"the points do not determine the cameras: {cure}") from error


def doubts(rig: Rig) -> list[str]:
    """List what looks wrong with a rig although it could be solved."""
    sentences = [
        f"{camera.name} is off by {camera.reprojection_rms_px:.1f} px, far more than usual: "
        "check the plate's sizes and heights, and whether a point is wrong"
        for camera in rig.cameras
        if camera.reprojection_rms_px > USUAL_RMS_PX
    ]
    sentences += [sentence for camera in rig.cameras for sentence in _odd(camera)]
    span_m = math.dist(rig.volume_min, rig.volume_max)
    if not USUAL_SPAN_M[0] < span_m < USUAL_SPAN_M[1]:
        sentences.append(f"the points span {span_m:.3g} m: check that they are given in mm")
    return sentences


def _odd(calibrated: CameraCalibration) -> Iterator[str]:
    """Yield what is odd about a camera's position and its pixels."""
    camera = decomposed(calibrated.matrix)
    if camera is None:
        return
    if oddity := odd_orientation(camera):
        yield f"{calibrated.name} camera {oddity}"
    stretch = camera.lens.fx / camera.lens.fy
    if abs(stretch - 1.0) > USUAL_STRETCH:
        yield (
            f"{calibrated.name} camera: its pixels come out {stretch:.2f} times as high as wide, which few are; "
            "check that positions, pitch and heights are all given in mm"
        )


def now() -> str:
    """The date and time of a rig, UTC."""
    return datetime.now(UTC).isoformat(timespec="seconds")


def parse_pair(text: str, option: str) -> tuple[int, int]:
    """Two whole numbers written as 640x480; ConfigError names the option."""
    first, _, second = text.lower().partition("x")
    if not (first.isdecimal() and second.isdecimal() and min(int(first), int(second)) > 0):
        raise ConfigError(f"{option} must be two whole numbers with an x between them, not {text!r}")
    if max(int(first), int(second)) > MAX_PICTURE_PX:
        raise ConfigError(f"{option} is too large: {text}")
    return int(first), int(second)


def describe(calibrated: Calibrated) -> str:
    """A new rig in words: reprojection error per camera, 3D error per axis, lenses, warnings."""
    rig = calibrated.rig
    cameras = ", ".join(f"{camera.name} {camera.reprojection_rms_px:.3f} px" for camera in rig.cameras)
    lines = [f"reprojection rms: {cameras}", f"3D error rms: {_axes(rig.error_rms)}"]
    if rig.leave_one_out_rms is not None:
        lines.append(f"3D error rms, each left out in turn: {_axes(rig.leave_one_out_rms)}")
    if rig.epipolar_px is not None:
        lines.append(f"epipolar residual, median: {rig.epipolar_px:.3f} px")
    lines += [f"lens, {camera.name}: {why}" for camera, why in zip(rig.cameras, rig.lens_choice, strict=False)]
    lines += [f"warning: {sentence}" for sentence in (*doubts(rig), *calibrated.warnings)]
    return "\n".join([*lines, f"rig written to {calibrated.out}"])


def as_builtins(calibrated: Calibrated) -> dict[str, Any]:
    """The same for programs."""
    rig, left_out = calibrated.rig, calibrated.rig.leave_one_out_rms
    return {
        "rig": calibrated.out,
        "reprojection_rms_px": {camera.name: camera.reprojection_rms_px for camera in rig.cameras},
        "error_rms_mm": [1e3 * value for value in rig.error_rms],
        "leave_one_out_rms_mm": None if left_out is None else [1e3 * value for value in left_out],
        "epipolar_px": rig.epipolar_px,
        "warnings": [*doubts(rig), *calibrated.warnings],
    }


def _axes(values: Vector3) -> str:
    x, y, z = (1e3 * value for value in values)
    return f"X {x:.3f} mm, Y {y:.3f} mm, Z {z:.3f} mm, total {math.sqrt(x * x + y * y + z * z):.3f} mm"
