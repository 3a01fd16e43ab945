"""Films of the arm's mesh in a room: who moves how, before which rig, and their frames."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from common.geometry import Array
from lab.films.arm.arm_mesh import Body, load_arm_mesh
from lab.films.arm.motions import ArmMotion, FilmMotion
from lab.films.arm.person import FilmedPerson, PersonInMotion
from lab.films.arm.postures import PostureName
from lab.films.film import FilmInstant, TrackingFilm
from lab.films.picture.rendering import FilmLayer, Picture, lay
from lab.films.picture.rigs import RigName, Size, film_cameras, film_rig
from lab.films.surroundings import FilmSetting, Surroundings
from local_site.calibration.physical_camera import PhysicalCamera
from local_site.simulation.motion import minimum_jerk
from local_site.simulation.room.config import SkinName

ENTERING_S, ENTERING_FROM = 0.7, np.array([1.1, 0.0, -0.15])
SHIRTS = ((70, 90, 130), (176, 172, 160), (120, 40, 44))


@dataclass(frozen=True, slots=True, kw_only=True)
class FilmedArm:
    """The operator's arm: what it does and in which posture, whose it is, and which side.

    `roll_deg` turns the hand about its axis, 0 is palm down.
    """

    motion: FilmMotion = "carry"
    posture: PostureName = "u_shape"
    body: Body = "average"
    tone: SkinName = "light"
    roll_deg: float = 20.0
    right: bool = True


@dataclass(frozen=True, slots=True, kw_only=True)
class MeshFilm:
    """The contents of a film; without an `arm` there is nothing to be tracked.

    `size` is (width, height) in px; `empty_s` is how long the room is empty first, after which the operator comes in.
    """

    name: str
    arm: FilmedArm | None = FilmedArm()
    setting: FilmSetting = FilmSetting()  # noqa: RUF009
    rig: RigName = "standard"
    size: Size = (640, 480)
    seconds: float = 5.0
    fps: float = 30.0
    empty_s: float = 0.0
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
    """The operator in his surroundings."""

    def __init__(self, config: MeshFilm, cameras: tuple[PhysicalCamera, ...]) -> None:
        self._config = config
        tone = config.arm.tone if config.arm else "medium"
        self._around = Surroundings(config.setting, cameras, config.size, tone, config.seed)
        self._operator = _operator(config.arm, config.seed).filming() if config.arm else None
        self._standing: list[FilmLayer | None] = []  # the operator's body once he has come in, of each camera

    def instant(self, k: int) -> FilmInstant:
        """The instant of one number."""
        t_s = k / self._config.fps
        pictures = self._around.pictures(t_s)
        truth = None
        if self._operator is not None and t_s >= self._config.empty_s:
            self._show(self._operator, t_s, pictures)
            truth = self._operator.truth(self._moving_s(t_s), self._entering(t_s))
        return FilmInstant(self._around.views(pictures, k, self._config.fps), truth)

    def _show(self, operator: PersonInMotion, t_s: float, pictures: Sequence[Picture]) -> None:
        lay(self._body(operator, t_s), pictures)
        times = self._around.exposure(t_s)
        lay(self._around.layers([operator.arm(self._moving_s(t), self._entering(t)) for t in times]), pictures)

    def _body(self, operator: PersonInMotion, t_s: float) -> list[FilmLayer | None]:
        if np.any(self._entering(t_s)):
            return self._around.layers([operator.body(self._entering(t)) for t in self._around.exposure(t_s)])
        if not self._standing:
            self._standing = self._around.layers([operator.body(np.zeros(3))])
        return self._standing

    def _moving_s(self, t_s: float) -> float:
        """The time in the motion, which begins when the operator has come in."""
        begin = self._config.empty_s + ENTERING_S if self._config.empty_s else 0.0
        return max(t_s - begin, 0.0)

    def _entering(self, t_s: float) -> Array:
        if not self._config.empty_s:
            return np.zeros(3)
        return (1.0 - minimum_jerk((t_s - self._config.empty_s) / ENTERING_S)) * ENTERING_FROM


def _operator(arm: FilmedArm, seed: int) -> FilmedPerson:
    mesh = load_arm_mesh(arm.body)
    motion = ArmMotion(arm.motion, mesh.upper_arm_m, mesh.forearm_m, np.radians(arm.roll_deg), seed)
    return FilmedPerson(mesh, motion, arm.posture, arm.tone, SHIRTS[seed % len(SHIRTS)], arm.right, seed=seed)
