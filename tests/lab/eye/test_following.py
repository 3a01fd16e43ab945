"""Following a film's arm: crops that lie upright about it, and points that come back to where they were seen."""

# ruff: noqa: E402
import numpy as np
import pytest

torch = pytest.importorskip("torch", reason="the eye's training needs torch: make eye")

from torch import Tensor

from lab.eye.arms.surface import CropKind
from lab.eye.following import EyeFollower, begun_at
from lab.eye.judging_films import judge_film
from lab.eye.network import EyeNetwork
from lab.films.meshed import FilmedArm, MeshFilm, mesh_film
from local_site.calibration.triangulation import project


class _LooksAhead(EyeNetwork):
    """Says that every point lies in the middle of its crop."""

    def forward(self, picture: Tensor) -> tuple[Tensor, Tensor, Tensor, Tensor]:
        points = torch.zeros(len(picture), 22, 8)
        points[..., :2] = 0.5
        return torch.zeros(len(picture), 5, 96, 96), points, torch.zeros(len(picture), 2), torch.zeros(0)


def _networks() -> dict[CropKind, EyeNetwork]:
    return {"arm": _LooksAhead(4), "hand": _LooksAhead(4)}


def test_points_in_the_middles_of_the_crops_are_those_about_which_these_were_cut() -> None:
    film = mesh_film(MeshFilm(name="a", seconds=0.1))
    instant = next(film.instants())
    assert instant.truth is not None
    arm = instant.truth.arm
    points = begun_at(arm.wrist, arm.index, arm.elbow)
    found = EyeFollower(film.rig, _networks()).followed(points, [view.current.image for view in instant.views.views])
    np.testing.assert_allclose(found[0], arm.wrist, atol=1e-3)  # the arm's crop lies about the wrist
    knuckles = points[[6, 10, 18]].mean(axis=0)
    np.testing.assert_allclose(found[9], knuckles, atol=1e-3)
    assert (
        np.abs(project(film.rig.cameras[0].matrix, found[0]) - project(film.rig.cameras[0].matrix, arm.wrist)).max() < 1
    )


def test_a_film_is_judged_over_all_its_pairs() -> None:
    figures = judge_film(mesh_film(MeshFilm(name="a", seconds=0.4)), _networks())
    assert figures is not None
    assert figures.pairs == 6
    assert figures.mean_mm["elbow"] > 150.0  # the wrist is told in its place
    assert figures.relative_mm["wrist"] > 0.0
    assert "6 pairs" in figures.line()


def test_a_left_arm_and_an_empty_room_are_not_judged() -> None:
    for film in (
        MeshFilm(name="left", arm=FilmedArm(right=False), seconds=0.1),
        MeshFilm(name="none", arm=None, seconds=0.1),
    ):
        assert judge_film(mesh_film(film), _networks()) is None
