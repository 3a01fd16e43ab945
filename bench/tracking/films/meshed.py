"""Films of the arm's mesh in a room: who moves how, before which rig, and their frames."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from bench.tracking.films.arm_mesh import MESH, Body, load_arm_mesh
from bench.tracking.films.backdrop import SeenRoom
from bench.tracking.films.film import FilmInstant, TrackingFilm
from bench.tracking.films.motions import ArmMotion, FilmMotion
from bench.tracking.films.person import FilmedPerson, PersonInMotion, Surface
from bench.tracking.films.postures import PostureName
from bench.tracking.films.rendering import Layer, Lighting, Picture, lit, rendered
from bench.tracking.films.rigs import RigName, Size, film_cameras, film_rig
from bench.tracking.films.rooms import RoomName, furnished
from bench.tracking.films.sensor import Sensor
from bench.tracking.films.skin import Tone
from common.cameras.camera import Frame
from common.clock import NS_PER_S
from common.geometry import Array
from local_site.calibration.physical_camera import PhysicalCamera
from local_site.simulation.motion import minimum_jerk
from local_site.tracking.tracker import View, Views

ENTERING_S, ENTERING_FROM = 0.7, np.array([1.1, 0.0, -0.15])
SECOND_AT = np.array([-0.05, 0.75, 0.05])
SHIRTS = ((70, 90, 130), (176, 172, 160), (120, 40, 44))
SKIN_SHIRT = (205, 160, 130)


@dataclass(frozen=True, slots=True, kw_only=True)
class MeshFilm:
    """What a film shows; with `operator` False nobody's arm is to be tracked, and there is no truth.

    `empty_s` is how long the room is empty first, after which the operator comes in; `shutter_s` the exposure, `noise`
    the sensor's in grey levels; `roll_deg` turns the hand about its axis, 0 is palm down.
    """

    name: str
    motion: FilmMotion = "carry"
    posture: PostureName = "u_shape"
    body: Body = "average"
    tone: Tone = "light"
    room: RoomName = "plain"
    rig: RigName = "standard"
    size: Size = (640, 480)
    seconds: float = 5.0
    fps: float = 30.0
    empty_s: float = 0.0
    shutter_s: float = 0.008
    noise: float = 2.0
    roll_deg: float = 20.0
    right: bool = True
    operator: bool = True
    second_person: bool = False
    torso: bool = True
    seed: int = 1


def mesh_film(config: MeshFilm) -> TrackingFilm:
    """The film of a configuration; its pictures are rendered as they are asked for."""
    cameras = film_cameras(config.rig, config.size)

    def instants() -> Iterator[FilmInstant]:
        stage = _Stage(config, cameras)
        for k in range(round(config.seconds * config.fps)):
            yield stage.instant(k)

    return TrackingFilm(config.name, film_rig(cameras, config.size), config.fps, instants)


class _Stage:
    """Everybody and everything before the cameras."""

    def __init__(self, config: MeshFilm, cameras: tuple[PhysicalCamera, ...]) -> None:
        self._config, self._cameras = config, cameras
        random = np.random.default_rng(config.seed)
        room = furnished(config.room, config.seed)
        self._rooms = [SeenRoom(room, camera, config.size) for camera in cameras]
        self._operator = _operator(config).filming() if config.operator else None
        self._second = _second(config).filming() if config.second_person else None
        self._lighting = _lighting(float(random.uniform(-0.5, 0.5)))
        self._sensor = Sensor(config.size, config.noise, random)
        self._standing: list[Layer | None] = []  # the operator's body once he has come in, of each camera

    def instant(self, k: int) -> FilmInstant:
        """The instant of one number."""
        t_s = k / self._config.fps
        t_ns = round(t_s * NS_PER_S)
        pictures = [room.at(t_s) for room in self._rooms]
        if self._second is not None:
            body = self._layers([self._second.body(_sway(t)) for t in self._exposure(t_s)])
            arm = self._layers([self._second.arm(t, _sway(t)) for t in self._exposure(t_s)])
            _lay(body, pictures)
            _lay(arm, pictures)
        truth = None
        if self._operator is not None and t_s >= self._config.empty_s:
            self._show_operator(self._operator, t_s, pictures)
            truth = self._operator.truth(self._moving_s(t_s), self._entering(t_s))
        frames = [Frame(self._sensor.exposed(picture), t_ns, k) for picture in pictures]
        return FilmInstant(Views(t_ns, tuple(View(frame) for frame in frames)), truth)

    def _show_operator(self, operator: PersonInMotion, t_s: float, pictures: Sequence[Picture]) -> None:
        if self._config.torso:
            _lay(self._operator_body(operator, t_s), pictures)
        arms = [operator.arm(self._moving_s(t), self._entering(t)) for t in self._exposure(t_s)]
        _lay(self._layers(arms), pictures)

    def _operator_body(self, operator: PersonInMotion, t_s: float) -> list[Layer | None]:
        if np.any(self._entering(t_s)):
            return self._layers([operator.body(self._entering(t)) for t in self._exposure(t_s)])
        if not self._standing:
            self._standing = self._layers([operator.body(np.zeros(3))])
        return self._standing

    def _layers(self, exposures: Sequence[Surface]) -> list[Layer | None]:
        """What each camera sees of a surface, given at both ends of an exposure or once."""
        surface = exposures[0]
        colours = lit(surface.vertices, surface.triangles, surface.albedo, self._lighting)
        vertices = [exposure.vertices for exposure in exposures]
        return [rendered(camera, self._config.size, vertices, surface.triangles, colours) for camera in self._cameras]

    def _exposure(self, t_s: float) -> tuple[float, ...]:
        half = self._config.shutter_s / 2
        return (t_s - half, t_s + half) if half else (t_s,)

    def _moving_s(self, t_s: float) -> float:
        """The time in the motion, which begins when the operator has come in."""
        begin = self._config.empty_s + ENTERING_S if self._config.empty_s else 0.0
        return max(t_s - begin, 0.0)

    def _entering(self, t_s: float) -> Array:
        if not self._config.empty_s:
            return np.zeros(3)
        return (1.0 - minimum_jerk((t_s - self._config.empty_s) / ENTERING_S)) * ENTERING_FROM


def _lay(layers: Sequence[Layer | None], pictures: Sequence[Picture]) -> None:
    for layer, picture in zip(layers, pictures, strict=True):
        if layer is not None:
            layer.over(picture)


def _operator(config: MeshFilm) -> FilmedPerson:
    mesh = load_arm_mesh(MESH, config.body)
    motion = ArmMotion(config.motion, mesh.upper_arm_m, mesh.forearm_m, np.radians(config.roll_deg), config.seed)
    shirt = SHIRTS[config.seed % len(SHIRTS)]
    return FilmedPerson(mesh, motion, config.posture, config.tone, shirt, config.right, seed=config.seed)


def _second(config: MeshFilm) -> FilmedPerson:
    """Somebody behind the operator with the other arm, in a shirt of skin's colour."""
    other = replace(config, body="muscular", motion="toggle", seed=config.seed + 1, right=not config.right)
    return replace(_operator(other), sleeve_srgb=SKIN_SHIRT, offset=SECOND_AT)


def _lighting(turn: float) -> Lighting:
    window, lamp = np.array([-0.5 + turn, -0.55, 0.75]), np.array([0.7 + turn, -0.6, 0.2])
    return Lighting(window / np.linalg.norm(window), lamp / np.linalg.norm(lamp))


def _sway(t_s: float) -> Array:
    return np.array([0.10 * np.sin(1.1 * t_s), 0.05 * np.sin(0.7 * t_s), 0.03 * np.sin(1.7 * t_s)])
