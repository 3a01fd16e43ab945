"""Films of an arm in rooms as scenes: for the silhouette tracker, too, whose room is dark."""

from collections.abc import Iterator

from lab.films.film import TrackingFilm
from lab.films.listing import composed_films, right_arm_films
from lab.films.scenes import ANY_BARE_ARM, RECORDINGS, Instant, TrackingScene

SEED = 1


def filmed_scenes() -> list[TrackingScene]:
    """The films of a right arm: of the mesh, and of the recorded arm where the recordings are."""
    films = right_arm_films(SEED) + (composed_films(SEED) if RECORDINGS.exists() else [])
    return [filmed(film) for film in films]


def filmed(film: TrackingFilm) -> TrackingScene:
    """A film as a scene."""

    def instants() -> Iterator[Instant]:
        return (Instant(i.views, None if i.truth is None else i.truth.arm) for i in film.instants())

    return TrackingScene(f"film {film.name}", film.rig, instants, ANY_BARE_ARM)
