"""One camera's picture of the operator in a room, in colour."""

from collections.abc import Sequence

import cv2
import numpy as np

from common.cameras.camera import Image
from common.geometry import Array
from local_site.simulation.body import ArmBody, BodyPose
from local_site.simulation.cameras import PinholeCamera
from local_site.simulation.config import SimulationConfig
from local_site.simulation.room.clothes import Shirt, is_before
from local_site.simulation.room.lamps import office_lamps
from local_site.simulation.room.layer import Body, draw
from local_site.simulation.room.scenery import draw_office
from local_site.simulation.room.shading import Shader
from local_site.simulation.room.skin import TONES
from local_site.simulation.room.surface import ArmSurface

NOISE_ROOM_PX = 128


class RoomView:
    """What one camera sees; `seed` decides about its noise, the configuration's about the room.

    Noise is drawn once and shifted about at random from frame to frame.
    """

    def __init__(self, camera: PinholeCamera, body: ArmBody, config: SimulationConfig, seed: int) -> None:
        self._camera, self._body = camera, body
        self._blur_px = config.picture.blur_sigma_px
        size = config.stereo.width_px, config.stereo.height_px
        self._room = draw_office(camera, size, np.random.default_rng(config.seed))
        self._with_chest, self._shoulder = self._room, np.full(3, np.nan)
        self._shader = Shader(office_lamps(camera), size)
        self._skin = _Skin(body, config)
        self._shirt = Shirt(body, np.random.default_rng(config.seed))
        self._random = np.random.default_rng(seed)
        self._noise = _noise(size, config.picture.noise_sigma, self._random)

    def render(self, poses: Sequence[BodyPose]) -> Image:
        """The picture (H, W, 3) BGR of the operator in poses spread over one exposure."""
        image = self._behind(poses[0].shoulder).copy()
        skins = [self._skin.body(pose) for pose in poses]
        sleeves = [self._shirt.sleeve(pose, skin.solid) for pose, skin in zip(poses, skins, strict=True)]
        in_order = [skins, sleeves] if is_before(sleeves[0], self._camera.centre) else [sleeves, skins]
        for bodies in in_order:
            self._draw(image, bodies)
        return self._with_noise(image)

    def _behind(self, shoulder: Array) -> Image:
        """The room with the operator's chest, which is drawn again only when the operator has moved."""
        if not np.array_equal(shoulder, self._shoulder):
            self._with_chest = self._room.copy()
            self._draw(self._with_chest, [self._shirt.chest(shoulder)])
            self._shoulder = shoulder
        return self._with_chest

    def _draw(self, image: Image, exposures: Sequence[Body]) -> None:
        draw(image, exposures, self._camera, self._shader, self._blur_px)

    def _with_noise(self, image: Image) -> Image:
        x, y = self._random.integers(0, NOISE_ROOM_PX, size=2)
        height, width = image.shape[:2]
        brighter, darker = (part[y : y + height, x : x + width] for part in self._noise)
        cv2.add(image, brighter, dst=image)
        return np.asarray(cv2.subtract(image, darker, dst=image), dtype=np.uint8)


class _Skin:
    """The bare arm's body by its pose."""

    def __init__(self, body: ArmBody, config: SimulationConfig) -> None:
        self._body = body
        self._surface = ArmSurface(body)
        self._coat = self._surface.coat(TONES[config.room.skin], np.random.default_rng(config.seed))

    def body(self, pose: BodyPose) -> Body:
        solid = self._body.solid(pose)
        return Body(solid, self._body.parts, self._surface.weights, self._body.backs(pose), self._coat)


def _noise(size: tuple[int, int], sigma: float, random: np.random.Generator) -> tuple[Image, Image]:
    """What noise adds and what it takes away, (H, W, 3) each; two sums of bytes are faster than one of integers."""
    shape = size[1] + NOISE_ROOM_PX, size[0] + NOISE_ROOM_PX, 3
    noise = np.rint(sigma * random.standard_normal(shape, dtype=np.float32))
    return np.maximum(noise, 0).astype(np.uint8), np.maximum(-noise, 0).astype(np.uint8)
