"""Surroundings of the operator before the cameras: a room, perhaps a second person, and how pictures are taken."""

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.random import Generator

from common.cameras.camera import Frame, Image
from common.clock import NS_PER_S
from common.geometry import Array
from lab.films.arm.arm_mesh import load_arm_mesh
from lab.films.arm.motions import ArmMotion
from lab.films.arm.person import ColouredSurface, FilmedPerson
from lab.films.picture.light import Lighting, lit
from lab.films.picture.rendering import FilmLayer, Picture, lay, rendered
from lab.films.picture.rigs import Size
from lab.films.room.rooms import DESK, DESK_SHAPE, SHADE_PX, WALL, FurnishedRoom, RoomName, furnished
from local_site.calibration.physical_camera import PhysicalCamera
from local_site.simulation.room.config import SkinName
from local_site.simulation.room.panels import lines_of_sight, out_of_focus
from local_site.tracking.tracker import View, Views

SECOND_AT = np.array([-0.05, 0.75, 0.05])  # of the second person from the operator, m
SKIN_SHIRT = (205, 160, 130)  # sRGB: a shirt of the colour of skin
FOCUS_SIGMA_PX = 0.55
MOST_PX = 16000.0  # a warp in whole and parts of px holds no more
NOISE_MARGIN_PX = 61  # every picture shows another part of one larger picture of noise


@dataclass(frozen=True, slots=True, kw_only=True)
class FilmSetting:
    """The room, a second bare-armed person behind the operator, the exposure in s, the noise in grey levels."""

    room: RoomName = "plain"
    second_person: bool = False
    shutter_s: float = 0.008
    noise: float = 2.0


class SeenRoom:
    """The pictures of a room that one camera takes; the warp is computed once."""

    def __init__(self, room: FurnishedRoom, camera: PhysicalCamera, size: tuple[int, int]) -> None:
        self._room = room
        sight = lines_of_sight(camera, size)
        (to_wall, wall), (to_desk, desk) = (plane.met(camera.centre, sight) for plane in (WALL, DESK))
        height, width = DESK_SHAPE
        desk_inside = np.all((desk >= 0) & (desk < (width, height)), axis=-1) & (to_desk < to_wall)
        self._shaded = _fixed(np.where(desk_inside[..., None], desk, wall) / SHADE_PX)
        self._wall = _fixed(wall)
        self._desk_at = desk_inside
        seen_desk = cv2.remap(room.desk, *_fixed(desk), cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
        self._desk = np.asarray(seen_desk, np.uint8)[desk_inside]
        self._still = self._seen(room.wall) if room.moving is None else None

    def at(self, t_s: float) -> Picture:
        """Return the picture (H, W, 3), BGR from 0 to 255, at a time in s; the caller may draw on it."""
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


class Sensor:
    """What a lens and a sensor make of pictures of one size (width, height): a little blur, noise, whole grey levels.

    The noise is of one strength in grey levels.
    """

    def __init__(self, size: tuple[int, int], noise: float, random: Generator) -> None:
        self._random = random
        shape = (size[1] + NOISE_MARGIN_PX, size[0] + NOISE_MARGIN_PX, 3)
        self._noise = np.rint(random.normal(0.0, noise, shape)).astype(np.int16)

    def exposed(self, picture: Picture) -> Image:
        """Return the picture (H, W, 3) as it is read out."""
        soft = cv2.GaussianBlur(cv2.convertScaleAbs(picture), (3, 3), FOCUS_SIGMA_PX)
        height, width = soft.shape[:2]
        top, left = self._random.integers(0, NOISE_MARGIN_PX, 2)
        noise = self._noise[top : top + height, left : left + width]
        return np.asarray(cv2.add(soft, noise, dtype=cv2.CV_8U), dtype=np.uint8)


class Surroundings:
    """A setting before cameras whose pictures are of one size (width, height)."""

    def __init__(
        self, setting: FilmSetting, cameras: Sequence[PhysicalCamera], size: Size, tone: SkinName, seed: int
    ) -> None:
        """`seed` decides the room, the light, the noise and, with `tone`, the second person, who shows the left arm."""
        self._setting, self._cameras, self._size = setting, cameras, size
        random = np.random.default_rng(seed)
        room = furnished(setting.room, seed)
        self._rooms = [SeenRoom(room, camera, size) for camera in cameras]
        self._second = _second(tone, seed).filming() if setting.second_person else None
        self._lighting = _lighting(float(random.uniform(-0.5, 0.5)))
        self._sensor = Sensor(size, setting.noise, random)

    def pictures(self, t_s: float) -> list[Picture]:
        """Draw what each camera sees without the operator; the caller may draw on it."""
        pictures = [room.at(t_s) for room in self._rooms]
        if self._second is not None:
            times = self.exposure(t_s)
            lay(self.layers([self._second.body(_sway(t)) for t in times]), pictures)
            lay(self.layers([self._second.arm(t, _sway(t)) for t in times]), pictures)
        return pictures

    def layers(self, exposures: Sequence[ColouredSurface]) -> list[FilmLayer | None]:
        """Render what each camera sees of a surface, given at both ends of an exposure or once."""
        surface = exposures[0]
        colours = lit(surface.vertices, surface.triangles, surface.albedo, self._lighting)
        vertices = [exposure.vertices for exposure in exposures]
        return [rendered(camera, self._size, vertices, surface.triangles, colours) for camera in self._cameras]

    def exposure(self, t_s: float) -> tuple[float, ...]:
        """Return both ends of the exposure about a time, s; only the time without an exposure."""
        half = self._setting.shutter_s / 2
        return (t_s - half, t_s + half) if half else (t_s,)

    def views(self, pictures: Sequence[Picture], number: int, fps: float) -> Views:
        """Read the pictures out of the cameras, at the instant of frame `number`."""
        t_ns = round(number * NS_PER_S / fps)
        frames = [Frame(self._sensor.exposed(picture), t_ns, number) for picture in pictures]
        return Views(t_ns, tuple(View(frame) for frame in frames))


def _fixed(warp: Array) -> tuple[cv2.typing.MatLike, cv2.typing.MatLike]:
    """Convert a warp (H, W, 2) in px to the form that is applied fastest."""
    clipped = np.clip(warp, -MOST_PX, MOST_PX).astype(np.float32)
    return cv2.convertMaps(clipped[..., 0], clipped[..., 1], cv2.CV_16SC2)


def _second(tone: SkinName, seed: int) -> FilmedPerson:
    mesh = load_arm_mesh("muscular")
    motion = ArmMotion("toggle", mesh.upper_arm_m, mesh.forearm_m, np.radians(20.0), seed)
    return FilmedPerson(mesh, motion, "u_shape", tone, SKIN_SHIRT, right=False, offset=SECOND_AT, seed=seed)


def _lighting(turn: float) -> Lighting:
    window, lamp = np.array([-0.5 + turn, -0.55, 0.75]), np.array([0.7 + turn, -0.6, 0.2])
    return Lighting(window / np.linalg.norm(window), lamp / np.linalg.norm(lamp))


def _sway(t_s: float) -> Array:
    return np.array([0.10 * np.sin(1.1 * t_s), 0.05 * np.sin(0.7 * t_s), 0.03 * np.sin(1.7 * t_s)])
