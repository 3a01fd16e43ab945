"""The last pictures of a run as PNG: the views of the cell, the annotated operator views, and all of them in one."""

from collections.abc import Mapping
from pathlib import Path

import cv2
import numpy as np
import simplejpeg

from common.cameras.camera import Image
from common.cameras.images import write_image
from farhand.loopback.recorder import CameraRecord

OVERVIEW = "overview"
TILE = (480, 360)


def save_camera_views(cameras: Mapping[str, CameraRecord], folder: Path) -> None:
    """Write the last picture of every camera as NAME.png."""
    for name, camera in cameras.items():
        if camera.last is not None:
            write_image(folder, name, simplejpeg.decode_jpeg(camera.last.jpeg, colorspace="BGR"))


def save_overview(names: tuple[str, ...], folder: Path) -> None:
    """Join the pictures NAME.png of a folder into overview.png, two in a row; a missing one stays black."""
    tiles = [_tile(folder / f"{name}.png") for name in names]
    tiles += [np.zeros_like(tiles[0])] * (len(tiles) % 2)
    rows = [np.hstack(tiles[k : k + 2]) for k in range(0, len(tiles), 2)]
    write_image(folder, OVERVIEW, np.vstack(rows))


def _tile(path: Path) -> Image:
    picture = cv2.imread(str(path), cv2.IMREAD_COLOR)
    if picture is None:
        return np.zeros((TILE[1], TILE[0], 3), dtype=np.uint8)
    return np.asarray(cv2.resize(picture, TILE, interpolation=cv2.INTER_AREA), dtype=np.uint8)
