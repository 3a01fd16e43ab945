"""Films of the arm's mesh: the truth lies on the arm in every picture, and absences are absences."""

from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest

from lab.films.arm.arm_mesh import load_arm_mesh
from lab.films.arm.motions import ArmMotion
from lab.films.arm.posing import PosedArm
from lab.films.arm.postures import posture_angles
from lab.films.listing import mesh_films
from lab.films.meshed import FilmedArm, MeshFilm, mesh_film
from lab.films.surroundings import FilmSetting
from local_site.calibration.triangulation import project

QUIET = FilmSetting(shutter_s=0.0, noise=0.0)
SMALL = MeshFilm(name="small", setting=QUIET, size=(320, 240), seconds=0.2)
POINTS = ("elbow", "wrist", "index", "thumb")


def instants(config):
    return list(mesh_film(config).instants())


@lru_cache(maxsize=1)
def empty_room(config):
    """The first instant without the operator, the same for each arm."""
    return next(mesh_film(config).instants())


def changed(config):
    """Where (H, W) each view differs from the same room without the operator, and the truth."""
    one, empty = next(mesh_film(config).instants()), empty_room(replace(config, arm=None))
    pairs = zip(one.views.views, empty.views.views, strict=True)
    return [np.abs(a.current.image.astype(int) - b.current.image).max(axis=2) > 8 for a, b in pairs], one.truth


@pytest.mark.parametrize("right", [True, False])
@pytest.mark.parametrize("rig", ["standard", "distorted", "close"])
def test_the_truth_lies_on_the_arm_in_every_view(rig, right):
    config = replace(SMALL, rig=rig, arm=FilmedArm(right=right))
    masks, truth = changed(config)
    for mask, camera in zip(masks, mesh_film(config).rig.cameras, strict=True):
        for name in POINTS:
            x, y = np.round(camera.distort_pixels(project(camera.matrix, getattr(truth.arm, name)))).astype(int)
            assert mask[y - 1 : y + 2, x - 1 : x + 2].any(), name


def test_the_index_ends_at_its_truth():
    config = replace(SMALL, size=(640, 480), arm=FilmedArm(posture="pointing", motion="hold"))
    masks, truth = changed(config)
    beyond = truth.arm.index + 0.012 * (truth.arm.index - truth.arm.wrist) / np.linalg.norm(
        truth.arm.index - truth.arm.wrist
    )
    for mask, camera in zip(masks, mesh_film(config).rig.cameras, strict=True):
        x, y = np.round(project(camera.matrix, beyond)).astype(int)
        assert not mask[y, x]


@pytest.mark.parametrize("body", ["average", "thin", "muscular"])
@pytest.mark.parametrize("motion", ["carry", "turn", "elbow_swing", "toggle"])
def test_bones_keep_their_lengths_in_every_motion(body, motion):
    mesh = load_arm_mesh(body)
    arm = ArmMotion(motion, mesh.upper_arm_m, mesh.forearm_m, 0.3, seed=1)
    for t_s in np.arange(0.0, 7.0, 0.25):
        pose = arm.pose(t_s)
        assert np.linalg.norm(pose.elbow - pose.shoulder) == pytest.approx(mesh.upper_arm_m)
        assert np.linalg.norm(pose.wrist - pose.elbow) == pytest.approx(mesh.forearm_m)
        assert np.linalg.det(pose.operator_R_hand) == pytest.approx(1.0)


def test_the_elbow_swings_through_ninety_degrees():
    mesh = load_arm_mesh("average")
    arm = ArmMotion("elbow_swing", mesh.upper_arm_m, mesh.forearm_m, 0.3, seed=1)
    forearms = [(p.wrist - p.elbow) / mesh.forearm_m for p in map(arm.pose, np.arange(0.0, 3.0, 0.1))]
    cosines = np.array(forearms) @ np.array(forearms).T
    assert np.degrees(np.arccos(cosines.min())) == pytest.approx(90.0, abs=1.0)


def test_postures_differ_as_their_names_say():
    mesh = load_arm_mesh("average")
    pose = ArmMotion("hold", mesh.upper_arm_m, mesh.forearm_m, 0.3, seed=1).pose(0.0)
    arm = PosedArm(mesh)
    reach, gap = {}, {}
    for name in ("u_shape", "open", "fist", "pointing", "flat"):
        angles = posture_angles(name)
        truth = arm.truth(pose, angles, arm.vertices(pose, angles))
        reach[name] = float(np.linalg.norm(truth.index - truth.wrist))
        gap[name] = float(np.linalg.norm(truth.index - truth.thumb))
    assert reach["fist"] < 0.115
    assert min(reach["pointing"], reach["flat"], reach["open"]) > 0.15
    assert gap["fist"] < 0.05 < gap["u_shape"] < 0.11 < gap["open"]


def test_a_left_arm_mirrors_a_right_one():
    right, left = (instants(replace(SMALL, arm=FilmedArm(right=side)))[3].truth for side in (True, False))
    assert (right.right, left.right) == (True, False)
    assert left.arm.index[0] + right.arm.index[0] == pytest.approx(left.arm.elbow[0] + right.arm.elbow[0])
    assert left.arm.index[1:] == pytest.approx(right.arm.index[1:])
    for truth in (right, left):
        distal, _, dorsal = truth.operator_R_hand.T
        assert np.linalg.det(truth.operator_R_hand) == pytest.approx(1.0)
        assert distal @ (truth.arm.index - truth.arm.wrist) > 0
        assert dorsal[2] > 0.5


def test_the_room_is_empty_first_and_the_arm_then_comes_in():
    film = instants(replace(SMALL, empty_s=0.1, seconds=1.2))
    assert [i.truth is None for i in film[:5]] == [True, True, True, False, False]
    empty = [i.views.views[0].current.image for i in film[:3]]
    assert np.array_equal(empty[0], empty[2])
    moved = np.linalg.norm(film[3].truth.arm.wrist - film[-1].truth.arm.wrist)
    assert moved > 1.0
    assert np.linalg.norm(film[-1].truth.arm.wrist - film[-2].truth.arm.wrist) < 0.002


def test_the_hand_opens_in_picture_and_truth():
    truths = [i.truth for i in instants(replace(SMALL, arm=FilmedArm(motion="toggle"), seconds=1.5))]
    opened = [t.arm.hand_open for t in truths]
    assert not opened[0]
    assert any(opened)
    assert {t.posture for t in truths} == {"u_shape", "open"}


def test_every_run_is_the_same_and_noise_differs_from_picture_to_picture():
    config = replace(SMALL, setting=replace(QUIET, noise=2.0), arm=None)
    first, again = instants(config), instants(config)
    images = [[i.views.views[0].current.image for i in run] for run in (first, again)]
    assert all(np.array_equal(a, b) for a, b in zip(*images, strict=True))
    assert not np.array_equal(images[0][0], images[0][1])


def test_a_fast_arm_is_blurred_along_its_motion():
    sharp = replace(SMALL, empty_s=0.1, seconds=0.6)
    blurred = replace(sharp, setting=replace(QUIET, shutter_s=0.03))
    one, other = (instants(c)[14].views.views[0].current.image.astype(float) for c in (sharp, blurred))
    moved = np.abs(one - other)[:, 1:] > 6
    edges = [np.abs(np.diff(picture, axis=1))[moved].mean() for picture in (one, other)]
    assert np.count_nonzero(moved) > 500
    assert edges[1] < 0.8 * edges[0]


def test_a_second_person_moves_behind_the_operator():
    config = replace(SMALL, setting=replace(QUIET, second_person=True), arm=None, seconds=0.6)
    film = [i.views.views[0].current.image.astype(int) for i in instants(config)]
    assert np.abs(film[0] - film[-1]).max() > 40


def test_the_listed_films_have_names_of_their_own_and_begin():
    films = mesh_films(seed=1)
    assert len({film.name for film in films}) == len(films)
    absent = [film for film in films if film.name.startswith("no arm")]
    assert len(absent) == 4
    for film in (*absent[:1], films[0]):
        assert (next(film.instants()).truth is None) == (film in absent)
