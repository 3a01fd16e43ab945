"""A room as one camera sees it: wall and desk, each warped as its plane lies, sharp or out of focus."""

import cv2
import numpy as np
from numpy.typing import NDArray

from common.cameras.camera import Image
from common.geometry import Array
from lab.films.picture.rendering import Picture
from lab.films.room.rooms import (
    DESK_FRONT,
    DESK_LEFT,
    DESK_PX_PER_M,
    DESK_SHAPE,
    DESK_Z,
    SHADE_PX,
    WALL_LEFT,
    WALL_PX_PER_M,
    WALL_TOP,
    WALL_Y,
    FurnishedRoom,
)
from local_site.calibration.physical_camera import PhysicalCamera

Mask = NDArray[np.bool_]

FAR_M = 1e3
MOST_PX = 16000.0  # a warp in whole and parts of px holds no more
BLUR_SHARE = 0.0016  # of the picture's width: the room lies behind the focus


class SeenRoom:
    """The pictures of a room that one camera takes; the warp is computed once."""

    def __init__(self, room: FurnishedRoom, camera: PhysicalCamera, size: tuple[int, int]) -> None:
        self._room = room
        self._sigma = BLUR_SHARE * size[0]
        wall, desk, desk_is_nearer = _warps(camera, size)
        desk_inside = _inside(desk, DESK_SHAPE) & desk_is_nearer
        shaded = np.where(desk_inside[..., None], desk, wall) / SHADE_PX
        self._shaded = _fixed(shaded.astype(np.float32))
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
        blurred = cv2.GaussianBlur(picture, (0, 0), self._sigma)
        return np.asarray(blurred, np.float32)


def _fixed(warp: Picture) -> tuple[cv2.typing.MatLike, cv2.typing.MatLike]:
    """A warp in the form that is applied fastest."""
    clipped = np.clip(warp, -MOST_PX, MOST_PX)
    return cv2.convertMaps(clipped[..., 0], clipped[..., 1], cv2.CV_16SC2)


def _warps(camera: PhysicalCamera, size: tuple[int, int]) -> tuple[Picture, Picture, Mask]:
    """The pixels (H, W, 2) of wall and of desk that each pixel shows, and where the desk is nearer (H, W)."""
    across, down = np.meshgrid(np.arange(size[0], dtype=float), np.arange(size[1], dtype=float))
    pinhole = camera.lens.undistort_pixels(np.dstack([across, down]))
    lens = camera.lens
    slopes = (pinhole - (lens.cx, lens.cy)) / (lens.fx, lens.fy)
    rays = np.dstack([slopes, np.ones(slopes.shape[:2])]) @ camera.camera_R_operator
    centre = camera.centre
    to_wall = _distance(WALL_Y - centre[1], rays[..., 1])
    to_desk = _distance(DESK_Z - centre[2], rays[..., 2])
    wall, desk = (centre + distance[..., None] * rays for distance in (to_wall, to_desk))
    wall_px = np.dstack([wall[..., 0] - WALL_LEFT, WALL_TOP - wall[..., 2]]) * WALL_PX_PER_M
    desk_px = np.dstack([desk[..., 0] - DESK_LEFT, desk[..., 1] - DESK_FRONT]) * DESK_PX_PER_M
    return wall_px.astype(np.float32), desk_px.astype(np.float32), np.less(to_desk, to_wall)


def _distance(gap: float, slopes: Array) -> Array:
    """Compute how far along a ray with these slopes towards a plane the plane lies; FAR_M when behind."""
    along = gap / np.where(np.abs(slopes) < 1e-9, 1e-9, slopes)
    return np.where(along > 0, np.minimum(along, FAR_M), FAR_M)


def _inside(pixels: Picture, shape: tuple[int, int]) -> Mask:
    height, width = shape
    inside: Mask = np.all((pixels >= 0) & (pixels < (width, height)), axis=-1)
    return inside
