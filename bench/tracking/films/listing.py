"""Which films there are: a short set that covers tones, rooms, bodies, postures, rigs and absences."""

from dataclasses import replace

from bench.tracking.films.film import TrackingFilm
from bench.tracking.films.meshed import MeshFilm, mesh_film

_MESHED = (
    MeshFilm(name="plain, light, carry"),
    MeshFilm(name="office, medium, carry, empty first", room="office", tone="medium", body="muscular", empty_s=1.0),
    MeshFilm(name="office, dark, turn", room="office", tone="dark", motion="turn", body="thin"),
    MeshFilm(name="wood, light, toggle, empty first", room="wood", motion="toggle", empty_s=1.0),
    MeshFilm(name="photograph, medium, elbow swing", room="photograph", tone="medium", motion="elbow_swing"),
    MeshFilm(name="office, second person, carry", room="office", second_person=True, empty_s=1.0),
    MeshFilm(name="plain, left arm, carry", right=False),
    MeshFilm(name="fan, distorted lens, pointing", room="fan", rig="distorted", posture="pointing"),
    MeshFilm(name="office, close, flat hand turns", room="office", rig="close", motion="turn", posture="flat"),
    MeshFilm(name="plain, high, fist", rig="high", posture="fist", tone="medium"),
    MeshFilm(name="office, wide, 1280x960", room="office", rig="wide", size=(1280, 960), seconds=3.0),
    MeshFilm(name="no arm, fan", room="fan", operator=False),
    MeshFilm(name="no arm, wood and shadows", room="wood", operator=False),
    MeshFilm(name="no arm, another person", room="office", operator=False, second_person=True),
)


def mesh_films(seed: int) -> list[TrackingFilm]:
    """The films of the mesh, with rooms, light and tremor of this seed."""
    return [mesh_film(replace(config, seed=seed)) for config in _MESHED]
