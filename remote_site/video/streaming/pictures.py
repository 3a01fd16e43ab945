"""Pictures as they are sent: whether they show anything, their size, and JPEG."""

import cv2
import numpy as np
import simplejpeg

from common.cameras.camera import Image

FLAT = 3.0  # standard deviation of the brightness


def is_dark(image: Image, dark_level: float) -> bool:
    """Return whether a picture shows nothing: nearly all of it is below a level of brightness, or all is alike.

    Nearly all is the mean and two standard deviations of the brightness, 0 to 255.
    """
    grey = image if image.ndim == 2 else cv2.cvtColor(image, cv2.COLOR_BGR2GRAY)
    mean, deviation = cv2.meanStdDev(grey)
    brightness, contrast = float(mean[0, 0]), float(deviation[0, 0])
    return contrast < FLAT or brightness + 2.0 * contrast < dark_level


def encode_jpeg(image: Image, quality: int) -> bytes:
    """A JPEG (colours at half resolution) of a grey (H, W) or BGR (H, W, 3) picture; quality 1 to 100."""
    picture = np.ascontiguousarray(image)
    if picture.ndim == 2:
        return bytes(simplejpeg.encode_jpeg(picture[:, :, None], quality, "GRAY", "Gray"))
    return bytes(simplejpeg.encode_jpeg(picture, quality, "BGR", "420"))


def shrunk(image: Image, scale: float) -> Image:
    """The picture at a fraction (0 to 1) of its width and height."""
    if scale >= 1.0:
        return image
    return np.asarray(cv2.resize(image, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA), dtype=np.uint8)
