"""Which films there are: a short set that covers tones, rooms, bodies, postures, rigs and absences."""

from dataclasses import replace

from lab.films.composed import ComposedFilm, composed_film
from lab.films.film import TrackingFilm
from lab.films.meshed import FilmedArm, MeshFilm, mesh_film
from lab.films.surroundings import FilmSetting

_PLAIN, _OFFICE, _WOOD, _PHOTOGRAPH, _FAN, _POSTER = (
    FilmSetting(room="plain"),
    FilmSetting(room="office"),
    FilmSetting(room="wood"),
    FilmSetting(room="photograph"),
    FilmSetting(room="fan"),
    FilmSetting(room="poster"),
)
_CROWDED = FilmSetting(room="office", second_person=True)

_MESHED = (
    MeshFilm(name="plain, light, carry"),
    MeshFilm(
        name="office, medium, carry, empty first",
        arm=FilmedArm(tone="medium", body="muscular"),
        setting=_OFFICE,
        empty_s=1.0,
    ),
    MeshFilm(name="office, dark, turn", arm=FilmedArm(tone="dark", motion="turn", body="thin"), setting=_OFFICE),
    MeshFilm(name="wood, light, toggle, empty first", arm=FilmedArm(motion="toggle"), setting=_WOOD, empty_s=1.0),
    MeshFilm(
        name="photograph, medium, elbow swing",
        arm=FilmedArm(tone="medium", motion="elbow_swing"),
        setting=_PHOTOGRAPH,
    ),
    MeshFilm(name="office, second person, carry", setting=_CROWDED, empty_s=1.0),
    MeshFilm(name="plain, left arm, carry", arm=FilmedArm(right=False)),
    MeshFilm(name="fan, distorted lens, pointing", arm=FilmedArm(posture="pointing"), setting=_FAN, rig="distorted"),
    MeshFilm(
        name="office, close, flat hand turns",
        arm=FilmedArm(motion="turn", posture="flat"),
        setting=_OFFICE,
        rig="close",
    ),
    MeshFilm(name="plain, high, fist", arm=FilmedArm(posture="fist", tone="medium"), rig="high"),
    MeshFilm(name="office, wide, 1280x960", setting=_OFFICE, rig="wide", size=(1280, 960), seconds=3.0),
    MeshFilm(name="plain, four cameras, hold", arm=FilmedArm(motion="hold"), rig="four", seconds=2.0),
    MeshFilm(name="no arm, fan", arm=None, setting=_FAN),
    MeshFilm(name="no arm, wood and shadows", arm=None, setting=_WOOD),
    MeshFilm(name="no arm, poster of a hand", arm=None, setting=_POSTER),
    MeshFilm(name="no arm, another person", arm=None, setting=_CROWDED),
)
_COMPOSED = (
    ComposedFilm(name="recorded yz, light, office", recording="yz", setting=_OFFICE, empty_s=1.0),
    ComposedFilm(name="recorded toggle, medium, wood", recording="toggle", tone="medium", setting=_WOOD, empty_s=1.0),
    ComposedFilm(name="recorded elbow, dark, plain", recording="icr_elbow", tone="dark", setting=_PLAIN, empty_s=1.0),
    ComposedFilm(name="recorded pick, light, crowded", recording="pick", setting=_CROWDED, empty_s=1.0),
)


def mesh_films(seed: int) -> list[TrackingFilm]:
    """The films of the mesh, with rooms, light and tremor of this seed."""
    return [mesh_film(replace(config, seed=seed)) for config in _MESHED]


def right_arm_films(seed: int) -> list[TrackingFilm]:
    """Those films of the mesh that show a right arm."""
    return [mesh_film(replace(config, seed=seed)) for config in _MESHED if config.arm is not None and config.arm.right]


def composed_films(seed: int) -> list[TrackingFilm]:
    """The films composed of recordings, with rooms of this seed."""
    return [composed_film(replace(config, seed=seed)) for config in _COMPOSED]
