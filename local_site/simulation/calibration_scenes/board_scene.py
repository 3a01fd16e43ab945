"""Pictures of a printed board before two cameras, rendered by following each pixel's ray to the print."""

from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

from common.cameras.camera import Image
from common.geometry import Array
from local_site.calibration.boards import Board
from local_site.calibration.physical_camera import Lens, PhysicalCamera

SIZE = (640, 480)
PX_PER_SQUARE = 48
SAMPLES = 2


def print_of(board: Board) -> Image:
    """The print, PX_PER_SQUARE to a square, with a white margin of one square."""
    if board.kind == "charuco":
        dictionary = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, f"DICT_{board.dictionary}"))
        made = cv2.aruco.CharucoBoard((board.columns, board.rows), board.square, board.marker, dictionary)
        inner = made.generateImage((board.columns * PX_PER_SQUARE, board.rows * PX_PER_SQUARE), marginSize=0)
    else:
        black = np.indices((board.rows, board.columns)).sum(axis=0) % 2 == 0
        inner = np.kron(np.where(black, 0, 255), np.ones((PX_PER_SQUARE, PX_PER_SQUARE))).astype(np.uint8)
    return np.pad(np.asarray(inner, dtype=np.uint8), PX_PER_SQUARE, constant_values=255)


@lru_cache(maxsize=6)
def rays_of(lens: Lens) -> NDArray[np.float32]:
    """The ray (x/z, y/z) of every sample of every pixel of a picture of SIZE, (SAMPLES H, SAMPLES W, 2)."""
    ticks = [(np.arange(SAMPLES * n) + 0.5) / SAMPLES - 0.5 for n in SIZE]
    slopes = (lens.undistort_pixels(np.stack(np.meshgrid(*ticks), axis=-1)) - (lens.cx, lens.cy)) / (lens.fx, lens.fy)
    return slopes.astype(np.float32)


class BoardRenderer:
    """Renders one print for one camera, in pictures of SIZE; noise is drawn from a seeded generator."""

    def __init__(self, board: Board, camera: PhysicalCamera, seed: int) -> None:
        self._print, self._board, self._camera = print_of(board), board, camera
        self._random = np.random.default_rng(seed)
        self._rays = rays_of(camera.lens)

    def picture(self, rotation: Array, translation: Array) -> Image:
        """The board at a pose (operator_R_board, translation in m) as a grey picture."""
        R = self._camera.camera_R_operator @ rotation
        t = self._camera.to_camera(translation)
        square, px = self._board.square, PX_PER_SQUARE
        print_H_board = np.array([[px / square, 0.0, px], [0.0, px / square, px], [0.0, 0.0, 1.0]])
        print_H_ray = print_H_board @ np.linalg.inv(np.column_stack([R[:, :2], t]))
        x, y = cv2.split(cv2.perspectiveTransform(self._rays, print_H_ray) - np.float32(0.5))
        behind = self._rays @ print_H_ray[2, :2].astype(np.float32) <= -print_H_ray[2, 2]
        x[behind] = -1e4
        fine = cv2.remap(self._print, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_CONSTANT, borderValue=30)
        coarse = cv2.GaussianBlur(cv2.resize(fine, SIZE, interpolation=cv2.INTER_AREA), (0, 0), 0.7)
        noise = 2.0 * self._random.standard_normal(coarse.shape)
        picture: Image = np.clip(0.8 * coarse.astype(float) + 10 + noise, 0, 255).astype(np.uint8)
        return picture
