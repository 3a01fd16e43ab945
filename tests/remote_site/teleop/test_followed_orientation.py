"""The followed orientation: never faster than allowed, no drift, and no swing by a finger taken for another."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from common.clock import NS_PER_MS
from common.geometry import Array, angle_between, rotation_from_vector
from remote_site.motion.catch_up import CATCH_UP_RAD_S
from remote_site.session.samples import Accepted
from remote_site.teleop.followed_orientation import FollowedOrientation
from tests.present import present
from tests.remote_site.remote_loop import hand

FRAME_NS = 33 * NS_PER_MS
FRAME_S = FRAME_NS / 1e9
FREE = math.inf
FLIP = rotation_from_vector(np.array([math.pi, 0.0, 0.0]))


def turned(degrees, axis=(0.0, 0.0, 1.0)):
    return rotation_from_vector(math.radians(degrees) * np.array(axis))


def judged(k, orientation, deg_s=FREE):
    """The k-th sample, which may turn the tool so fast about each axis."""
    about_x, about_y, about_z = np.radians(np.broadcast_to(deg_s, 3)).tolist()
    return Accepted(
        hand(k, k * FRAME_NS), np.zeros(3), orientation, k * FRAME_NS, False, 1.0, (about_x, about_y, about_z)
    )


def followed(orientations, deg_s=FREE, begin=None):
    """What is followed of one orientation or None per frame, after `begin`."""
    following = FollowedOrientation()
    following.begin(np.eye(3) if begin is None else begin)
    many = deg_s if isinstance(deg_s, list) else [deg_s] * len(orientations)
    given_samples = zip(orientations, many, strict=True)
    return [following.follow(judged(k, o, d), FRAME_S) for k, (o, d) in enumerate(given_samples, start=1)]


def apart_deg(first, second):
    return math.degrees(angle_between(first, second))


def test_a_sure_hand_is_followed_exactly():
    hands = [turned(k, (0.6, 0.0, 0.8)) for k in range(40)]
    assert all(np.array_equal(f, h) for f, h in zip(followed(hands), hands, strict=True))


def test_before_the_hand_has_shown_an_orientation_there_is_none_and_the_first_is_followed_at_once():
    following = FollowedOrientation()
    assert following.follow(judged(1, None), FRAME_S) is None
    assert np.array_equal(present(following.follow(judged(2, turned(80)), FRAME_S)), turned(80))


def test_a_slow_limit_is_kept_and_what_it_leaves_is_made_up_slowly():
    hands = [turned(20.0)] * 200
    found = followed(hands, [10.0] * 20 + [FREE] * 180)
    assert apart_deg(found[19], np.eye(3)) == pytest.approx(20 * FRAME_S * 10.0)
    steps = [apart_deg(a, b) for a, b in itertools.pairwise(found[20:])]
    assert max(steps) <= math.degrees(CATCH_UP_RAD_S) * FRAME_S + 1e-6
    assert apart_deg(found[-1], turned(20.0)) < 1e-6


def test_what_was_withheld_is_made_up_without_drift_while_the_hand_goes_on_turning():
    hands = [turned(k) for k in range(30)]
    spoilt = [*hands[:10], *[None] * 15, *hands[25:], *[hands[-1]] * 100]
    assert apart_deg(followed(spoilt)[-1], hands[-1]) < 1e-6


def test_about_an_unsure_axis_the_tool_waits_while_it_turns_about_the_others():
    hands = [turned(k, (1.0, 0.0, 0.0)) @ turned(k) for k in range(11)]
    found = followed(hands, (0.0, FREE, FREE))
    assert apart_deg(found[-1], turned(10.0)) < 2.0
    assert apart_deg(found[-1], hands[-1]) > 8.0


def test_more_than_can_be_meant_is_not_made_up_and_no_drift_is_left_when_the_flip_ends():
    flipped = [turned(k) @ FLIP for k in range(10, 20)]
    back = [turned(20.0)] * 100
    found = followed([*[turned(0.0)] * 10, None, *flipped, None, *back])
    while_flipped = found[11:21]
    assert apart_deg(while_flipped[0], np.eye(3)) < 1e-6
    assert apart_deg(while_flipped[-1], turned(9.0)) < 1e-6  # it goes on with the hand, as from a new reference
    assert apart_deg(found[-1], turned(20.0)) < 1e-6


def test_the_slow_beginning_of_a_sudden_turn_is_taken_back_once():
    hands = [turned(a) for a in [*[0.0] * 20, 1.0, 3.0, 6.0]]
    found = followed([*hands, *[None] * 8])
    assert apart_deg(found[22], turned(6.0)) < 1e-6
    assert apart_deg(found[23], np.eye(3)) < 1e-6
    assert all(apart_deg(after, np.eye(3)) < 1e-6 for after in found[24:])


def test_no_more_is_taken_back_than_the_last_150_ms():
    found = followed([*[turned(k) for k in range(30)], None])
    assert apart_deg(found[-1], turned(29 - 150 / 33)) < 1.0


def test_a_new_reference_forgets_the_lag():
    following = FollowedOrientation()
    following.begin(np.eye(3))
    following.follow(judged(1, turned(20.0), 1.0), FRAME_S)
    following.begin(turned(20.0))
    assert np.array_equal(present(following.follow(judged(2, turned(20.0)), FRAME_S)), turned(20.0))


def test_after_a_hold_the_lag_is_the_one_from_before():
    following = FollowedOrientation()
    following.begin(np.eye(3))
    following.follow(judged(1, turned(20.0), 0.0), FRAME_S)
    assert apart_deg(following.resume(judged(9, turned(25.0), 0.0)), turned(5.0)) < 1e-6


def test_after_a_hold_nothing_more_is_taken_back():
    following = FollowedOrientation()
    following.begin(np.eye(3))
    for k in range(1, 20):
        following.follow(judged(k, turned(k)), FRAME_S)
    partly = present(following.follow(judged(20, None, 30.0), FRAME_S))
    assert apart_deg(partly, turned(19.0)) == pytest.approx(30.0 * FRAME_S)
    following.resume(judged(30, None))
    assert np.array_equal(present(following.follow(judged(31, None), FRAME_S)), partly)


def test_what_is_used_of_the_catch_up_speed_is_not_left_for_others():
    following = FollowedOrientation()
    following.begin(np.eye(3))
    following.follow(judged(1, turned(20.0), 0.0), FRAME_S)
    assert following.spare == 1.0
    before = following.follow(judged(2, turned(20.0)), FRAME_S, spare=0.25)
    assert following.spare == pytest.approx(0.75)
    assert apart_deg(before, np.eye(3)) == pytest.approx(0.25 * math.degrees(CATCH_UP_RAD_S) * FRAME_S)


vectors = st.tuples(*(st.floats(-1.0, 1.0) for _ in range(3)))
speeds = st.tuples(*(st.floats(0.0, 90.0) for _ in range(3)))


@settings(max_examples=150, deadline=None, derandomize=True)
@given(st.lists(st.tuples(vectors, speeds, st.booleans()), min_size=1, max_size=20))
def test_no_step_is_ever_faster_than_the_fastest_axis_allows(given_samples):
    following = FollowedOrientation()
    before: Array = np.eye(3)
    following.begin(before)
    for k, (vector, deg_s, shown) in enumerate(given_samples, start=1):
        sample = judged(k, rotation_from_vector(3.0 * np.array(vector)) if shown else None, deg_s)
        now = present(following.follow(sample, FRAME_S))
        assert apart_deg(before, now) <= max(deg_s) * FRAME_S + 1e-5
        before = now


@settings(max_examples=50, deadline=None, derandomize=True)
@given(st.integers(0, 10**6), st.floats(0.0, 120.0))
def test_a_limit_never_makes_a_resting_hand_less_calm(seed, deg_s):
    rng = np.random.default_rng(seed)
    hands = [rotation_from_vector(math.radians(1.0) * rng.normal(size=3)) for _ in range(60)]
    found = followed(hands, deg_s)
    spread, shown = (sum(angle_between(a, b) for a, b in itertools.pairwise(m)) for m in (found, hands))
    assert spread <= shown + 1e-6
    of_found, of_hands = (math.hypot(*(angle_between(one, np.eye(3)) for one in m)) for m in (found, hands))
    assert of_found <= 1.1 * of_hands  # just below the noise's own speed a limit shapes it more than it lessens it


def test_nothing_moves_while_nothing_moves():
    assert all(np.array_equal(f, turned(30.0)) for f in followed([turned(30.0)] * 30, 5.0, begin=turned(30.0)))


def test_a_second_sample_of_the_same_instant_turns_nothing_that_is_limited():
    following = FollowedOrientation()
    following.begin(np.eye(3))
    kept = following.follow(judged(1, turned(20.0), (FREE, 1.0, 1.0)), 0.0)
    assert apart_deg(kept, np.eye(3)) < 1e-9
    assert apart_deg(following.follow(judged(2, turned(20.0)), 0.0), np.eye(3)) < 1e-6
