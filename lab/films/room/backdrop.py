"""A room as one camera sees it: wall and desk, each warped as its plane lies, sharp or out of focus."""

import cv2
import numpy as np

from common.cameras.camera import Image
from common.geometry import Array
from lab.films.picture.rendering import Picture
from lab.films.room.rooms import DESK, DESK_SHAPE, SHADE_PX, WALL, FurnishedRoom
from local_site.calibration.physical_camera import PhysicalCamera
from local_site.simulation.room.panels import lines_of_sight, out_of_focus

MOST_PX = 16000.0  # a warp in whole and parts of px holds no more


class SeenRoom:
    """The pictures of a room that one camera takes; the warp is computed once."""

    def __init__(self, room: FurnishedRoom, camera: PhysicalCamera, size: tuple[int, int]) -> None:
        self._room = room
        sight = lines_of_sight(camera, size)
        (to_wall, wall), (to_desk, desk) = (plane.met(camera.centre, sight) for plane in (WALL, DESK))
        height, width = DESK_SHAPE
        desk_inside = np.all((desk >= 0) & (desk < (width, height)), axis=-1) & (to_desk < to_wall)
        shaded = np.where(desk_inside[..., None], desk, wall) / SHADE_PX
        self._shaded = _fixed(shaded)
        self._wall = _fixed(wall)
        self._desk_at = desk_inside
        seen_desk = cv2.remap(room.desk, *_fixed(desk), cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
        self._desk = np.asarray(seen_desk, np.uint8)[desk_inside]
        self._still = self._seen(room.wall) if room.moving is None else None

    def at(self, t_s: float) -> Picture:
        """The picture (H, W, 3), BGR from 0 to 255, at a time in s; the caller may draw on it."""
        if self._still is not None:
            return self._still.copy() if self._room.shade is None else self._still * self._shade(self._room.shade(t_s))
        wall = self._room.wall.copy()
        if self._room.moving is not None:
            self._room.moving(wall, t_s)
        return self._seen(wall)

    def _shade(self, shade: Picture) -> Picture:
        seen = cv2.remap(shade, *self._shaded, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REFLECT)
        return np.asarray(seen, dtype=np.float32)[..., None]

    def _seen(self, wall: Image) -> Picture:
        picture = np.asarray(cv2.remap(wall, *self._wall, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REFLECT), np.uint8)
        picture[self._desk_at] = self._desk
        return out_of_focus(picture).astype(np.float32)


def _fixed(warp: Array) -> tuple[cv2.typing.MatLike, cv2.typing.MatLike]:
    """A warp in the form that is applied fastest."""
    clipped = np.clip(warp, -MOST_PX, MOST_PX).astype(np.float32)
    return cv2.convertMaps(clipped[..., 0], clipped[..., 1], cv2.CV_16SC2)
