"""Photographs that scikit-image brings under free licences, as material for rooms."""

from importlib.util import find_spec
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

# Pictures without arms to be found, in the public domain or under CC0 or CC BY: scikit-image lists whose each is.
PACKAGE = "skimage"
PHOTOGRAPHS = (
    *("brick.png", "camera.png", "chelsea.png", "coffee.png", "coins.png", "grass.png", "gravel.png"),
    *("hubble_deep_field.jpg", "ihc.png", "motorcycle_left.png", "page.png", "retina.jpg", "rocket.jpg", "text.png"),
    "astronaut.png",
)
GREATEST_PX = 640


def installed_photographs() -> list[NDArray[np.uint8]]:
    """Read the photographs (H, W, 3), RGB, that are installed; none without scikit-image."""
    spec = find_spec(PACKAGE)
    if spec is None or spec.origin is None:
        return []
    pictures = [cv2.imread(str(Path(spec.origin).parent / "data" / name), cv2.IMREAD_COLOR) for name in PHOTOGRAPHS]
    return [_fitted(np.asarray(picture[:, :, ::-1], np.uint8)) for picture in pictures if picture is not None]


def _fitted(picture: NDArray[np.uint8]) -> NDArray[np.uint8]:
    scale = GREATEST_PX / max(picture.shape[:2])
    if scale >= 1.0:
        return picture
    return np.asarray(cv2.resize(picture, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA), np.uint8)
