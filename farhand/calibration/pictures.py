"""Pictures for a calibration: read from folders, patterns and videos, and written with what was found in them."""

import glob
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

from common.cameras.camera import Image
from common.cameras.images import IMAGE_SUFFIXES
from common.cameras.sources import open_camera
from common.errors import CameraError, ConfigError
from common.geometry import Array
from local_site.calibration.control_points import CAMERAS
from local_site.calibration.coverage import coverage_map
from local_site.calibration.found import draw_found
from local_site.preview.picture_files import write_picture

MAX_PICTURES = 500


@dataclass(frozen=True, slots=True)
class PictureJob:
    """The cameras' sources by name, the rig file to write, a folder for found pictures, serial numbers NAME=NUMBER."""

    sources: Mapping[str, str]
    out: Path
    pictures: Path | None = None
    serials: Sequence[str] = ()


def by_name(sources: Sequence[str | None]) -> dict[str, str]:
    """The sources that were given, by their cameras' names; ConfigError if one was left out between others."""
    present = [source for source in sources if source is not None]
    if list(sources[: len(present)]) != present:
        raise ConfigError("a fourth camera needs a third; give it as --third")
    return dict(zip(CAMERAS, present, strict=False))


def read_pictures(source: str, name: str) -> list[Image]:
    """All pictures of a folder, a pattern such as 'left_*.png', a file or a video, in the order of their names."""
    paths = [Path(path) for path in sorted(glob.glob(source))] if glob.has_magic(source) else [Path(source)]
    if paths and all(path.is_file() and path.suffix.lower() in IMAGE_SUFFIXES for path in paths):
        return [_read(path, name) for path in paths[:MAX_PICTURES]]
    if not paths:
        raise CameraError(f"camera {name}: no file matches {source}; put the pattern in quotes and check the folder")
    if not paths[0].exists():
        raise CameraError(f"camera {name}: {source} does not exist; give a folder of pictures, a pattern or a video")
    camera = open_camera(source, name)
    pictures: list[Image] = []
    try:
        while len(pictures) < MAX_PICTURES and (frame := camera.read()) is not None:
            pictures.append(frame.image)
    finally:
        camera.close()
    return pictures


def _read(path: Path, name: str) -> Image:
    picture = cv2.imread(str(path), cv2.IMREAD_COLOR)
    if picture is None:
        raise CameraError(f"camera {name}: {path} is not an image that can be read; remove or replace it")
    return np.asarray(picture, dtype=np.uint8)


def write_found(folder: Path, name: str, number: int, picture: Image, found: tuple[Array, Sequence[str]]) -> None:
    """Write a camera's picture of this number with what was found in it: pixels (N, 2) and their names."""
    write_picture(folder, f"{name}_{number}", draw_found(picture, *found))


def write_coverage(folder: Path, name: str, picture: Image, pixels: Array) -> None:
    """Write which parts of a camera's picture all its pixels (N, 2) cover."""
    write_picture(folder, f"{name}_coverage", coverage_map(pixels, size_of(picture), picture))


def size_of(picture: Image) -> tuple[int, int]:
    """Width and height, px."""
    return picture.shape[1], picture.shape[0]
