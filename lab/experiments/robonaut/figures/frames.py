"""Single frames of a film, as the report shows them: beside each the same with the model at the estimated pose."""

from collections.abc import Sequence

import numpy as np

from common.cameras.camera import Image
from farhand.reports.plate import plate
from lab.experiments.robonaut.footage import Footage, Tracked
from local_site.calibration.physical_camera import Lens
from local_site.kernels.pictures import as_colour
from local_site.simulation.hazel import FOCAL_PX, PRINCIPAL_PX
from local_site.tracking.config import MonocularConfig
from local_site.tracking.monocular.arm_model import ArmPose, ArmView, Patch, forearm_mesh, upper_arm_mesh

TILE_PX, COLUMNS = 400, 6
LINK_COLOURS = ((235, 160, 60), (60, 190, 250))  # BGR, of upper arm and forearm
TINT, LINE_TINT = 0.25, 0.8
RING_M, RING_LINE_M = 0.030, 0.003
SECTOR, SECTOR_LINE = np.radians(30.0), np.radians(5.0)


def frames_shown(numbers: Sequence[int], frames: int) -> tuple[int, ...]:
    """Which of the report's frames, counted from 1, are there; the last one if none is."""
    return tuple(number for number in numbers if number <= frames) or (frames,)


def frames_plate(footage: Footage, numbers: Sequence[int]) -> bytes:
    """The frames of these numbers, counted from 1, as PNG in rows of three."""
    tiles = [(f"frame {number}", footage.pictures[number - 1]) for number in numbers]
    return plate(tiles, COLUMNS // 2, TILE_PX)


def overlays_plate(footage: Footage, tracked: Tracked, numbers: Sequence[int], config: MonocularConfig) -> bytes:
    """The frames of these numbers, counted from 1, and below them the same with the model, as PNG."""
    view = ArmView(
        Lens(FOCAL_PX, FOCAL_PX, *PRINCIPAL_PX), upper_arm_mesh(config.upper_arm), forearm_mesh(config.forearm)
    )
    plain = [(f"frame {number}", footage.pictures[number - 1]) for number in numbers]
    modelled = [_modelled(view, picture, tracked.poses[n - 1]) for n, (_, picture) in zip(numbers, plain, strict=True)]
    return plate([*plain, *modelled], len(numbers), TILE_PX)


def _modelled(view: ArmView, picture: Image, pose: ArmPose | None) -> tuple[str, Image]:
    """A caption, and the picture (H, W, 3) with the model's visible surface and its lines."""
    canvas = as_colour(picture).copy()
    box = view.box(pose, picture.shape) if pose is not None else None
    if pose is None or box is None:
        return "lost", canvas
    part = canvas[box[1] : box[3], box[0] : box[2]]
    for patch, colour in zip(view.patches(pose, box), LINK_COLOURS, strict=True):
        share = np.where(_on_a_line(patch), LINE_TINT, TINT)[:, None]
        at = patch.rows, patch.columns
        part[at] = np.rint((1.0 - share) * part[at] + share * np.array(colour)).astype(np.uint8)
    return "with the model", canvas


def _on_a_line(patch: Patch) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
    """Which of the patch's pixels show a ring about the link or a line along it."""
    x, y, z = patch.points.T
    lines: np.ndarray[tuple[int], np.dtype[np.bool_]] = (z % RING_M < RING_LINE_M) | (
        np.arctan2(y, x) % SECTOR < SECTOR_LINE
    )
    return lines
