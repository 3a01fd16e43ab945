"""Image files: a folder of them as a recording, in the order of their names; pictures written for people."""

from pathlib import Path

import cv2
import numpy as np

from common.cameras.camera import Frame, Image
from common.clock import NS_PER_S
from common.errors import CameraError
from common.text import file_name

IMAGE_SUFFIXES = frozenset({".png", ".jpg", ".jpeg", ".bmp", ".pgm", ".tif", ".tiff"})


class ImageFolder:
    """The images of a folder sorted by name; image k is stamped k / fps seconds from the start."""

    def __init__(self, folder: Path, name: str, fps: float) -> None:
        self.name = name
        self._paths = sorted(path for path in folder.iterdir() if path.suffix.lower() in IMAGE_SUFFIXES)
        if not self._paths:
            raise CameraError(f"camera {name}: {folder} holds no image ({', '.join(sorted(IMAGE_SUFFIXES))})")
        self.fps = fps
        self.stated_frames = len(self._paths)
        self._seq = 0

    def read(self) -> Frame | None:
        """Read the next image, None after the last; CameraError names a file that is not an image."""
        if self._seq >= len(self._paths):
            return None
        path = self._paths[self._seq]
        image = cv2.imread(str(path), cv2.IMREAD_COLOR)
        if image is None:
            raise CameraError(f"camera {self.name}: {path} is not an image that can be read; remove or replace it")
        frame = Frame(np.asarray(image, dtype=np.uint8), round(self._seq * NS_PER_S / self.fps), self._seq)
        self._seq += 1
        return frame

    def close(self) -> None:
        """Do nothing: no file is held open between images."""


def write_image(folder: Path, name: str, image: Image) -> None:
    """Write NAME.png into a folder, which is created if missing; CameraError if it cannot be written."""
    path = folder / f"{file_name(name)}.png"
    try:
        folder.mkdir(parents=True, exist_ok=True)
        # Not cv2.imwrite, which leaves a truncated picture on a full disk without an error.
        path.write_bytes(cv2.imencode(".png", image)[1].tobytes())
    except OSError as error:
        why = error.strerror or error
        raise CameraError(f"cannot write {path}: {why}; choose a folder that can be written") from error
