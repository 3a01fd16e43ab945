"""How well the networks alone follow films' arms, with another rasteriser: `python -m lab.eye.judging_films`."""

from dataclasses import dataclass

import numpy as np

from common.geometry import Array
from lab.eye.arms.surface import CropKind
from lab.eye.following import EyeFollower, begun_at
from lab.eye.network import EyeNetwork
from lab.eye.trained import trained_networks
from lab.films.film import TrackingFilm
from lab.films.listing import composed_films, right_arm_films
from local_site.tracking.eye.arm_points import ELBOW, INDEX_TIP, THUMB_TIP, WRIST

LOST_M = 0.08  # the wrist is farther off than half a hand's width: the crops show something else
EVERY = 2  # of the instants
SEED = 1_000_001
JUDGED = {"elbow": ELBOW, "wrist": WRIST, "index": INDEX_TIP, "thumb": THUMB_TIP}


@dataclass(frozen=True, slots=True)
class FilmFigures:
    """One film: how many pairs, in which share of them the arm was lost, and by point the error's mean and that of the
    relative motion (after a constant offset), mm, over all pairs, lost ones included."""

    film: str
    pairs: int
    lost: float
    mean_mm: dict[str, float]
    relative_mm: dict[str, float]

    def line(self) -> str:
        """Write a line of a table."""
        points = ", ".join(f"{name} {self.mean_mm[name]:.0f} ({self.relative_mm[name]:.0f})" for name in JUDGED)
        return f"{self.film}: {self.pairs} pairs, lost {100 * self.lost:.0f} %, mm (relative): {points}"


def main() -> None:
    """Print a line for each film of a right arm."""
    networks = trained_networks()
    for film in [*right_arm_films(SEED), *composed_films(SEED)]:
        figures = judge_film(film, networks)
        if figures is not None:
            print(figures.line(), flush=True)


def judge_film(film: TrackingFilm, networks: dict[CropKind, EyeNetwork]) -> FilmFigures | None:
    """Follow the film's right arm from its true first place; None where it has none. A lost arm begins anew there."""
    follower, points, errors = EyeFollower(film.rig, networks), None, []
    for number, instant in enumerate(film.instants()):
        truth = instant.truth
        if truth is None or not truth.right or number % EVERY:
            continue
        if points is None:
            points = begun_at(truth.arm.wrist, truth.arm.index, truth.arm.elbow)
        points = follower.followed(points, [view.current.image for view in instant.views.views])
        true = np.array([truth.arm.elbow, truth.arm.wrist, truth.arm.index, truth.arm.thumb])
        errors.append(points[list(JUDGED.values())] - true)
        if np.linalg.norm(errors[-1][1]) > LOST_M:
            points = None
    return _figures(film.name, np.array(errors)) if errors else None


def _figures(film: str, errors: Array) -> FilmFigures:
    """Figures of errors (N, 4, 3) in m."""
    distance = 1e3 * np.linalg.norm(errors, axis=2)
    relative = 1e3 * np.linalg.norm(errors - errors.mean(axis=0), axis=2)
    return FilmFigures(
        film=film,
        pairs=len(errors),
        lost=float(np.mean(distance[:, 1] > 1e3 * LOST_M)),
        mean_mm=dict(zip(JUDGED, distance.mean(axis=0).tolist(), strict=True)),
        relative_mm=dict(zip(JUDGED, relative.mean(axis=0).tolist(), strict=True)),
    )


if __name__ == "__main__":
    main()
