"""Films on disk: what is read is what was written, picture by picture."""

import numpy as np
import pytest

from common.cameras.camera import Frame
from common.errors import CameraError
from lab.films.film import FilmInstant, HandTruth, TrackingFilm
from lab.films.film_file import read_film, read_films, write_film
from lab.films.picture.rigs import film_cameras, film_rig
from local_site.simulation.body import ArmTruth
from local_site.tracking.tracker import View, Views
from tests.present import present

SIZE = (64, 48)


def small_film(name="a film, small", count=4):
    random = np.random.default_rng(3)
    images = random.integers(0, 256, (count, 2, SIZE[1], SIZE[0], 3), np.uint8)
    points = random.uniform(0.0, 1.0, (count, 4, 3)).round(6)

    def instants():
        for k in range(count):
            t_ns = round(k * 1e9 / 20)
            shoulder, elbow, wrist, palm = points[k]
            arm = ArmTruth(shoulder, elbow, wrist, palm, hand_open=k == 2)
            truth = None if k == 0 else HandTruth(arm, np.eye(3) if k > 1 else None, right=k != 3, posture="fist")
            yield FilmInstant(Views(t_ns, tuple(View(Frame(image, t_ns, k)) for image in images[k])), truth)

    rig = film_rig(film_cameras("distorted", SIZE), SIZE)
    return TrackingFilm(name, rig, 20.0, instants)


def test_a_film_comes_back_as_it_was_written(tmp_path):
    film = small_film()
    assert write_film(film, tmp_path / "one") == 4
    read = read_film(tmp_path / "one")
    assert (read.name, read.rig, read.fps) == (film.name, film.rig, 20.0)
    for one, other in zip(film.instants(), read.instants(), strict=True):
        for a, b in zip(one.views.views, other.views.views, strict=True):
            assert np.array_equal(a.current.image, b.current.image)
        assert other.views.t_ns == pytest.approx(one.views.t_ns, abs=1000)
        assert (one.truth is None) == (other.truth is None)
        if one.truth is not None:
            assert present(other.truth).arm.index == pytest.approx(one.truth.arm.index)
            assert present(other.truth).arm.hand_open == one.truth.arm.hand_open
            assert (present(other.truth).right, present(other.truth).posture) == (one.truth.right, "fist")
            assert (present(other.truth).operator_R_hand is None) == (one.truth.operator_R_hand is None)


def test_all_films_of_a_folder_are_found(tmp_path):
    for name in ("b", "a"):
        write_film(small_film(name), tmp_path / name)
    (tmp_path / "notes").mkdir()
    assert [film.name for film in read_films(tmp_path)] == ["a", "b"]


@pytest.mark.parametrize("lines", [3, 5])
def test_a_film_whose_truth_does_not_fit_is_refused(lines, tmp_path):
    write_film(small_film(), tmp_path)
    (tmp_path / "truth.jsonl").write_text("null\n" * lines)
    with pytest.raises(CameraError, match="lines of truth"):
        list(read_film(tmp_path).instants())
