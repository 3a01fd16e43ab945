"""Pictures to JPEG."""

import numpy as np
import simplejpeg

from common.cameras.camera import Image


def encode_jpeg(image: Image, quality: int) -> bytes:
    """A JPEG (colours at half resolution) of a grey (H, W) or BGR (H, W, 3) picture; quality 1 to 100."""
    picture = np.ascontiguousarray(image)
    if picture.ndim == 2:
        return bytes(simplejpeg.encode_jpeg(picture[:, :, None], quality, "GRAY", "Gray"))
    return bytes(simplejpeg.encode_jpeg(picture, quality, "BGR", "420"))
