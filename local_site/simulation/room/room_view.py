"""One camera's picture of the operator in a room, in colour."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Protocol

import cv2
import numpy as np

from common.cameras.camera import Image
from common.geometry import Array
from local_site.simulation.body import ArmBody, BodyPose
from local_site.simulation.cameras import PinholeCamera
from local_site.simulation.config import SimulationConfig
from local_site.simulation.room.bystanders import Face, SecondArm
from local_site.simulation.room.config import DisturbanceName
from local_site.simulation.room.layer import Brush, ShadedLayer
from local_site.simulation.room.moving_things import Fan, Shadows
from local_site.simulation.room.panels import Panel, film
from local_site.simulation.room.person import Arm, Shirt, is_before
from local_site.simulation.room.scenery import office
from local_site.simulation.room.surface import STRETCHED

NOISE_ROOM_PX = 128


class Disturbance(Protocol):
    """Something behind the operator on the pictures (H, W, 3) of one camera."""

    def stand(self, image: Image) -> None:
        """Draw what never moves."""

    def move(self, image: Image, filmed_s: float) -> None:
        """Draw what moves, at a time in s since the cameras began."""


def make_disturbances(
    names: tuple[DisturbanceName, ...], camera: PinholeCamera, brush: Brush, size: tuple[int, int], seed: int
) -> list[Disturbance]:
    """Those that are not part of the room itself, the farthest first, the same for all cameras of one seed."""
    made: dict[DisturbanceName, Disturbance] = {
        "fan": Fan(camera),
        "shadows": Shadows(size, np.random.default_rng(seed)),
        "face": Face(brush, camera, np.random.default_rng(seed)),
        "second_arm": SecondArm(brush, np.random.default_rng(seed)),
    }
    return [disturbance for name, disturbance in made.items() if name in names]


def room_views(cameras: Sequence[PinholeCamera], body: ArmBody, config: SimulationConfig) -> list["RoomView"]:
    """A view for each camera, of the one room that the configuration's seed decides about."""
    panels = office(np.random.default_rng(config.seed), config.room.disturbances)
    return [RoomView(camera, body, config, panels, config.seed + k) for k, camera in enumerate(cameras)]


class RoomView:
    """One camera's view of the operator and of an office's `panels`; `seed` decides about its noise.

    Noise is drawn once and shifted about at random from frame to frame.
    """

    def __init__(
        self, camera: PinholeCamera, body: ArmBody, config: SimulationConfig, panels: Sequence[Panel], seed: int
    ) -> None:
        size, room = (config.stereo.width_px, config.stereo.height_px), config.room
        self._camera = camera
        self._brush = Brush(camera, size, config.picture.blur_sigma_px)
        self._arm = Arm(body, room, np.random.default_rng(config.seed))
        self._shirt = Shirt(body, np.random.default_rng(config.seed))
        self._disturbances = make_disturbances(room.disturbances, camera, self._brush, size, config.seed)
        self._room = film(panels, camera, size)
        for disturbance in self._disturbances:
            disturbance.stand(self._room)
        self._is_covered = room.sleeve == "long"
        self._shoulder: Array = np.full(3, np.nan)
        self._chest: ShadedLayer | None = None
        # Inner loops are compiled now, not during the first exposure.
        self._draw_operator(self._room.copy(), [_in_view(np.array(config.stereo.centre))])
        self._random = np.random.default_rng(seed)
        self._noise = _noise(size, config.picture.noise_sigma, self._random)

    def render(self, poses: Sequence[BodyPose], filmed_s: float) -> Image:
        """The picture (H, W, 3) BGR of the operator in poses spread over one exposure; without poses, of the room.

        `filmed_s` is the time since the cameras began, s.
        """
        image = self._room.copy()
        for disturbance in self._disturbances:
            disturbance.move(image, filmed_s)
        if poses:
            self._draw_operator(image, poses)
        return self._with_noise(image)

    def _draw_operator(self, image: Image, poses: Sequence[BodyPose]) -> None:
        chest = self._chest_at(poses[0].shoulder)
        if chest is not None:
            chest.lay_on(image)
        skins = [self._arm.posed(pose) for pose in poses]
        sleeves = [self._shirt.sleeve(pose, skin.solid) for pose, skin in zip(poses, skins, strict=True)]
        in_order = [skins, sleeves] if is_before(sleeves[0], self._camera.centre) else [sleeves, skins]
        if self._is_covered:
            covers = [self._shirt.long_sleeve(skin.solid) for skin in skins]
            in_order = [skins, covers, sleeves]
        for bodies in in_order:
            self._brush.draw(image, bodies)

    def _chest_at(self, shoulder: Array) -> ShadedLayer | None:
        """The chest, which is drawn again only when the operator has moved."""
        if not np.array_equal(shoulder, self._shoulder):
            self._shoulder, self._chest = shoulder, self._brush.layer([self._shirt.chest(shoulder)])
        return self._chest

    def _with_noise(self, image: Image) -> Image:
        x, y = self._random.integers(0, NOISE_ROOM_PX, size=2)
        height, width = image.shape[:2]
        brighter, darker = (part[y : y + height, x : x + width] for part in self._noise)
        cv2.add(image, brighter, dst=image)
        return np.asarray(cv2.subtract(image, darker, dst=image), dtype=np.uint8)


def _in_view(centre: Array) -> BodyPose:
    return replace(
        STRETCHED,
        shoulder=STRETCHED.shoulder + centre,
        elbow=STRETCHED.elbow + centre,
        wrist=STRETCHED.wrist + centre,
    )


def _noise(size: tuple[int, int], sigma: float, random: np.random.Generator) -> tuple[Image, Image]:
    """Draw what noise adds and takes away, (H, W, 3) each; two sums of bytes are faster than one of integers."""
    shape = size[1] + NOISE_ROOM_PX, size[0] + NOISE_ROOM_PX, 3
    noise = np.rint(sigma * random.standard_normal(shape, dtype=np.float32))
    return np.maximum(noise, 0).astype(np.uint8), np.maximum(-noise, 0).astype(np.uint8)
