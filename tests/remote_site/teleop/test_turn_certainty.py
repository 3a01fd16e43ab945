"""How fast an uncertain hand may turn the tool: by the rotation's own deviation about each axis of the hand."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from common.geometry import hand_rotation, vector_from_rotation
from common.messages.hand import PointCovariances
from remote_site.safety.config import CertaintyConfig, SafetyConfig
from remote_site.teleop.turn_certainty import FREE, rotation_covariance, turn_speeds
from tests.present import present
from tests.remote_site.remote_loop import hand

CONFIG = SafetyConfig()
POINTS = [np.array(point) for point in ([0.1, -0.2, 0.3], [0.13, -0.37, 0.31], [0.03, -0.3, 0.28])]
SURE = (1e-6, 0.0, 0.0, 1e-6, 0.0, 1e-6)


def even(sigma_mm):
    """The covariance of a point that is known to so many mm along each axis."""
    variance = (sigma_mm * 1e-3) ** 2
    return (variance, 0.0, 0.0, variance, 0.0, variance)


def speeds(thumb, *, inferred=False, **changes):
    """About the hand's axes, deg/s."""
    known = PointCovariances(**({"wrist": SURE, "index": SURE, "thumb": thumb} | changes))
    sample = hand(1, 0, thumb_inferred=inferred, covariance=known)
    rotation = present(hand_rotation(present(sample.wrist), present(sample.index), present(sample.thumb)))
    return np.degrees(turn_speeds(sample, rotation, CONFIG))


def test_the_rotations_covariance_is_that_of_many_spoilt_hands():
    rng = np.random.default_rng(5)
    spread = [0.002 * rng.normal(size=(3, 3)) for _ in POINTS]
    of_wrist, of_index, of_thumb = (root @ root.T for root in spread)
    wrist, index, thumb = POINTS
    rotation = present(hand_rotation(*POINTS))
    turns = []
    for _ in range(4000):
        spoilt = [point + root @ rng.normal(size=3) for point, root in zip(POINTS, spread, strict=True)]
        turns.append(vector_from_rotation(rotation.T @ present(hand_rotation(*spoilt))))
    expected = rotation_covariance(rotation, index - wrist, thumb - wrist, (of_wrist, of_index, of_thumb))
    assert np.cov(np.array(turns).T) == pytest.approx(expected, abs=0.08 * np.trace(expected))


def test_what_does_not_turn_the_hand_makes_it_no_less_sure():
    """An error that all points share, and one of the thumb along the line from the wrist."""
    wrist, index, thumb = POINTS
    along = np.outer(thumb - wrist, thumb - wrist)
    none = np.zeros((3, 3))
    about_the_palm = rotation_covariance(
        present(hand_rotation(*POINTS)), index - wrist, thumb - wrist, (none, none, along)
    )
    assert about_the_palm[0, 0] == pytest.approx(0.0, abs=1e-12)
    assert about_the_palm[1, 1] == pytest.approx(0.0, abs=1e-12)


def test_a_sender_that_knows_no_covariance_turns_the_tool_freely():
    sample = hand(1, 0)
    rotation = present(hand_rotation(present(sample.wrist), present(sample.index), present(sample.thumb)))
    assert turn_speeds(sample, rotation, CONFIG) == FREE
    assert speeds(None, wrist=None, index=None).tolist() == list(FREE)


def test_a_thumb_that_is_poorly_known_takes_from_the_roll_and_leaves_the_pointing_free():
    roll, pitch, yaw = speeds(even(12.0))
    assert 0.0 < roll < 120.0
    assert (pitch, yaw) == (np.inf, np.inf)
    assert roll == pytest.approx(speeds(even(12.0), inferred=True)[0] * 120.0 / 45.0)


def test_an_inferred_thumb_never_turns_the_tool_faster_than_configured_and_slower_where_it_is_less_sure():
    assert speeds(SURE, inferred=True) == pytest.approx([45.0] * 3)
    roll, pitch, yaw = speeds(even(12.0), inferred=True)
    assert 0.0 < roll < 45.0
    assert (pitch, yaw) == pytest.approx((45.0, 45.0))


@pytest.mark.parametrize("left_out", ["wrist", "index", "thumb"])
def test_a_sample_that_states_how_well_some_of_the_points_are_known_is_not_believed_about_the_others(left_out):
    assert speeds(**({"thumb": SURE} | {left_out: None})).tolist() == [0.0, 0.0, 0.0]


@pytest.mark.parametrize("broken", [np.inf, np.nan, -1.0])
def test_a_covariance_that_is_none_turns_nothing(broken):
    assert speeds((broken,) * 6).tolist() == [0.0, 0.0, 0.0]


@settings(max_examples=60, deadline=None, derandomize=True)
@given(st.floats(0.1, 200.0), st.floats(1.0, 3.0), st.booleans())
def test_a_point_that_is_known_less_well_never_turns_the_tool_faster(sigma_mm, factor, inferred):
    sure, unsure = (speeds(even(s), inferred=inferred) for s in (sigma_mm, factor * sigma_mm))
    assert (unsure <= sure).all()


def test_with_a_thumb_that_is_ever_less_sure_the_speed_falls_evenly_to_nothing():
    rolls = [speeds(even(sigma_mm), inferred=True)[0] for sigma_mm in np.arange(0.0, 30.0, 0.1)]
    steps = np.diff(rolls)
    assert rolls[-1] == 0.0
    assert steps.max() <= 0.0
    assert steps.min() > -1.0
    assert speeds(even(1e9), inferred=True).tolist() == [0.0, 0.0, 0.0]


def test_poor_must_lie_beyond_sure():
    with pytest.raises(ValueError, match=r"turn_poor_deg .* must be above turn_sure_deg"):
        CertaintyConfig(turn_poor_deg=8.0)
