"""Pictures to JPEG."""

import cv2
import numpy as np
import simplejpeg

from common.cameras.camera import Image


def encode_jpeg(image: Image, quality: int) -> bytes:
    """A JPEG (colours at half resolution) of a grey (H, W) or BGR (H, W, 3) picture; quality 1 to 100."""
    picture = np.ascontiguousarray(image)
    if picture.ndim == 2:
        return bytes(simplejpeg.encode_jpeg(picture[:, :, None], quality, "GRAY", "Gray"))
    return bytes(simplejpeg.encode_jpeg(picture, quality, "BGR", "420"))


def shrunk(image: Image, scale: float) -> Image:
    """The picture at a share (0 to 1) of its width and height."""
    if scale >= 1.0:
        return image
    return np.asarray(cv2.resize(image, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA), dtype=np.uint8)
