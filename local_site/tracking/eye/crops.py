"""Square crops of a picture, of metric size, turned so that the hand stands upright in them; pure."""

from dataclasses import dataclass

import cv2
import numpy as np

from common.cameras.camera import Image
from common.geometry import Array

CROP_PX = 192
ARM_M, HAND_M = 0.64, 0.30  # what the width of a crop shows, at the wrist's depth


@dataclass(frozen=True, slots=True)
class PictureCrop:
    """A crop: the map (2, 3) from px of the camera's picture to px of the crop."""

    to_crop: Array

    def cut(self, picture: Image) -> Image:
        """Cut the crop (192, 192, 3) out of a picture (H, W, 3); black where it reaches beyond."""
        shrinks = np.linalg.det(self.to_crop[:, :2]) < 1.0
        flags = cv2.INTER_AREA if shrinks else cv2.INTER_LINEAR
        return np.asarray(cv2.warpAffine(picture, self.to_crop, (CROP_PX, CROP_PX), flags=flags), np.uint8)

    def in_picture(self, shares: Array) -> Array:
        """Map points (N, 2) in shares of the crop's width to px of the picture."""
        pixels: Array = (CROP_PX * shares - self.to_crop[:, 2]) @ self.back.T
        return pixels

    @property
    def back(self) -> Array:
        """The map (2, 2) of a way in px of the crop to one in px of the picture."""
        return np.asarray(np.linalg.inv(self.to_crop[:, :2]))


def crop_about(middle: Array, up: Array, width_px: float) -> PictureCrop:
    """Make the crop about a pixel (2,), this wide in the picture, in which a direction (2,) points up."""
    angle, scale = np.arctan2(up[0], -up[1]), CROP_PX / width_px
    turn = scale * np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    return PictureCrop(np.column_stack([turn, 0.5 * CROP_PX - turn @ middle]))


def in_colour(picture: Image) -> Image:
    """Give a picture three colours: a grey one (H, W) or (H, W, 1 or 2), or one with transparency (H, W, 4)."""
    if picture.ndim == 3 and picture.shape[2] >= 3:
        return np.ascontiguousarray(picture[..., :3])
    grey = picture if picture.ndim == 2 else np.ascontiguousarray(picture[..., 0])
    return np.asarray(cv2.cvtColor(grey, cv2.COLOR_GRAY2BGR), np.uint8)
