"""Writes pictures for people to look at."""

from pathlib import Path

import cv2

from common.cameras.camera import Image
from common.errors import CameraError


def write_picture(folder: Path, name: str, picture: Image) -> None:
    """Write NAME.png into a folder, which is made if need be; CameraError if it cannot be written."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        # Not cv2.imwrite, which leaves a cut picture on a full disk without a word.
        (folder / f"{name}.png").write_bytes(cv2.imencode(".png", picture)[1].tobytes())
    except OSError as error:
        why = error.strerror or error
        raise CameraError(f"cannot write {folder / name}.png: {why}; choose a folder that can be written") from error
