"""Pictures of a plate of discs before a camera, drawn by following each pixel's ray to the plate."""

import cv2
import numpy as np

from common.cameras.camera import Image
from local_site.calibration.physical_camera import PhysicalCamera
from local_site.calibration.plate import Plate
from local_site.simulation.calibration_scenes.board_scene import SAMPLES, SIZE, rays_of

MARGIN = 0.08


def plate_picture(plate: Plate, camera: PhysicalCamera, height: float, seed: int = 0, noise: float = 3.0) -> Image:
    """The level plate at a height in m as a grey picture: bright discs, a dark plate, a black room."""
    width, rows = SIZE
    slopes = rays_of(camera.lens)
    rays = np.dstack([slopes, np.ones(slopes.shape[:2])]) @ camera.camera_R_operator
    depth = (height - camera.centre[2]) / rays[..., 2]
    x, y = (camera.centre[k] + depth * rays[..., k] for k in (0, 1))
    extents = [(n - 1) * plate.pitch for n in plate.size]
    on_plate = (depth > 0) & (np.abs(x - extents[0] / 2) < extents[0] / 2 + MARGIN)
    on_plate &= np.abs(y - extents[1] / 2) < extents[1] / 2 + MARGIN
    nearest = [
        np.clip(np.round(v / plate.pitch), 0, n - 1) * plate.pitch for v, n in zip((x, y), plate.size, strict=True)
    ]
    on_disc = on_plate & (np.hypot(x - nearest[0], y - nearest[1]) < plate.diameter / 2)
    fine = np.where(on_disc, 215.0, np.where(on_plate, 32.0, 10.0))
    coarse = fine.reshape(rows, SAMPLES, width, SAMPLES).mean(axis=(1, 3))
    soft = cv2.GaussianBlur(coarse, (0, 0), 0.8) + noise * np.random.default_rng(seed).standard_normal(coarse.shape)
    picture: Image = np.clip(soft, 0, 255).astype(np.uint8)
    return picture
