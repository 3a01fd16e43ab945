"""Guided calibration: which pairs are kept, what is said to be missing, and the likely cause of a poor rig."""

import cv2
import numpy as np
import pytest
from msgspec.structs import replace

from farhand.doctor.findings import Severity, worst
from farhand.setup.board_page import BOARD
from farhand.setup.guided_calibration import Guide, judge_rig, take_pairs
from local_site.simulation.cameras import calibrate_simulated
from local_site.simulation.config import SimulationConfig
from tests.farhand.setup.board_cameras import HELD_FRAMES, SIDES, pictures
from tests.farhand.setup.scripted_person import ScriptedPerson, no_bar

NAMES = ("left", "right")
FEW = 6


def pairs():
    return list(zip(*(pictures(source, FEW) for source in SIDES), strict=True))


@pytest.fixture(scope="module")
def taken():
    """Each pose held, until nothing more comes: the numbers and pictures that were kept, and what was said."""
    guide, kept, person = Guide(BOARD, NAMES), [], ScriptedPerson()
    held = [pair for pair in pairs() for _ in range(HELD_FRAMES)]
    take_pairs(guide, held, lambda number, pair: kept.append((number, pair)), person)
    return guide, kept, person


@pytest.mark.slow
def test_each_pose_that_both_cameras_see_is_kept_once(taken):
    _, kept, person = taken
    seen = [k for k in range(FEW) if k != 3]  # the left camera does not see the board in the fourth pose
    assert [number for number, _ in kept] == list(range(1, len(seen) + 1))
    for (_, pair), k in zip(kept, seen, strict=True):
        assert all(np.array_equal(a, b) for a, b in zip(pair, pairs()[k], strict=True))
    assert any("left does not see it" in line for line in person.shown)


def test_what_is_missing_becomes_less_and_is_told_with_each_pair(taken):
    guide, kept, person = taken
    assert person.told[0].startswith("pair 1 kept; left view: ")
    assert len(person.told) == len(kept)
    assert guide.missing[-1] == f"{10 - len(kept)} more poses"


@pytest.mark.slow
def test_pairs_of_an_earlier_run_count_and_are_not_taken_again(taken):
    guide, kept, _ = taken
    later, again = Guide(BOARD, NAMES), []
    with no_bar() as show:
        later.restore([pair for _, pair in kept], show)
    assert (later.kept, later.missing) == (guide.kept, guide.missing)
    take_pairs(later, [pairs()[0]] * HELD_FRAMES, lambda *pair: again.append(pair), ScriptedPerson())
    assert not again


def test_a_board_that_moves_is_not_kept():
    guide = Guide(BOARD, NAMES)
    moving = [tuple(np.roll(picture, 2 * k, axis=1) for picture in pairs()[1]) for k in range(HELD_FRAMES)]
    assert not any(guide.judge(pair).kept for pair in moving)


def test_a_blurred_board_is_refused_by_its_view():
    guide = Guide(BOARD, NAMES)
    left, right = (cv2.resize(picture, (1920, 1440)) for picture in pairs()[1])
    for _ in range(HELD_FRAMES):
        judged = guide.judge((left, cv2.GaussianBlur(right, (0, 0), 2.0)))
        assert not judged.kept
        assert "blurred in the left and right view" in judged.line or "blurred in the right view" in judged.line


def rig_with(rms_px, left_out=1.0):
    rig = calibrate_simulated(SimulationConfig())
    cameras = tuple(replace(camera, reprojection_rms_px=rms) for camera, rms in zip(rig.cameras, rms_px, strict=True))
    return replace(rig, cameras=cameras, error_rms=(1e-4,) * 3, leave_one_out_rms=(left_out * 1e-4,) * 3)


def test_a_usual_rig_has_no_doubts():
    assert worst(judge_rig(rig_with((0.08, 0.1)), 12)) is Severity.OK


@pytest.mark.parametrize(
    ("rms_px", "cause"),
    [((0.9, 0.1), "only the left camera is off: it was moved"), ((0.8, 0.9), "the board is not flat, moved")],
)
def test_a_poor_residual_has_a_likely_cause(rms_px, cause):
    residual, _ = judge_rig(rig_with(rms_px), 12)
    assert residual.level is Severity.WARNING
    assert residual.cure.startswith(cause)


def test_too_few_poses_show_in_the_error_of_what_was_left_out():
    _, error = judge_rig(rig_with((0.1, 0.1), left_out=3.0), 10)
    assert error.level is Severity.WARNING
    assert error.cure == "take more pairs at more places"
