"""Photographs that Python packages bring under free licences, as material for rooms."""

from importlib.util import find_spec
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

# Pictures without arms to be found. scikit-image's and scikit-learn's are in the public domain or under CC0 or CC BY
# (each package lists them), those of Mahotas under its own MIT licence.
PHOTOGRAPHS = {
    "skimage": (
        *("data/brick.png", "data/camera.png", "data/chelsea.png", "data/coffee.png", "data/coins.png"),
        *("data/grass.png", "data/gravel.png", "data/hubble_deep_field.jpg", "data/ihc.png", "data/motorcycle_left.png"),
        *("data/page.png", "data/retina.jpg", "data/rocket.jpg", "data/text.png", "data/astronaut.png"),
    ),
    "sklearn": ("datasets/images/china.jpg", "datasets/images/flower.jpg"),
    "mahotas": ("demos/data/DepartmentStore.jpg", "demos/data/luispedro.jpg"),
}
GREATEST_PX = 640


def installed_photographs() -> list[NDArray[np.uint8]]:
    """Read the photographs (H, W, 3), RGB, of the packages that are installed; fewer where one is missing."""
    pictures = []
    for package, names in PHOTOGRAPHS.items():
        spec = find_spec(package)
        if spec is None or spec.origin is None:
            continue
        for name in names:
            picture = cv2.imread(str(Path(spec.origin).parent / name), cv2.IMREAD_COLOR)
            if picture is not None:
                pictures.append(_fitted(cv2.cvtColor(picture, cv2.COLOR_BGR2RGB)))
    return pictures


def _fitted(picture: NDArray[np.uint8]) -> NDArray[np.uint8]:
    scale = GREATEST_PX / max(picture.shape[:2])
    if scale >= 1.0:
        return picture
    return np.asarray(cv2.resize(picture, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA), np.uint8)
