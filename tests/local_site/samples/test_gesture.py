"""The open hand: debounced and counted once on its rising edge."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from common.clock import NS_PER_MS
from common.messages.hand import TrackingStatus
from local_site.samples.hand_sample import GestureConfig, OpenHand
from local_site.tracking.tracker import ArmEstimate

FRAME_NS = 33 * NS_PER_MS


def after_frame(state, k, seen):
    """The state after frame `k`, which saw the hand open or closed, or no hand (None)."""
    wrist = None if seen is None else np.zeros(3)
    estimate = ArmEstimate(k * FRAME_NS, TrackingStatus.TRACKED, "", wrist=wrist, hand_open=bool(seen))
    return state.observe(estimate, GestureConfig())


def run(observations):
    state = OpenHand()
    for k, seen in enumerate(observations):
        state = after_frame(state, k, seen)
    return state


def test_an_opening_counts_once_however_long_it_lasts():
    assert run([False] * 5 + [True] * 60).toggles == 1
    assert run([False] * 5 + [True] * 10 + [False] * 10 + [True] * 10).toggles == 2


def test_an_opening_counts_once_it_has_lasted_for_120_ms():
    for after_ms, toggles in ((119, 0), (120, 1)):
        state = OpenHand()
        for t_ns in (0, after_ms * NS_PER_MS):
            estimate = ArmEstimate(t_ns, TrackingStatus.TRACKED, "", wrist=np.zeros(3), hand_open=True)
            state = state.observe(estimate, GestureConfig())
        assert state.toggles == toggles


def test_flicker_counts_nothing_and_a_short_gap_splits_nothing():
    assert run([False, True, True, False] * 20).toggles == 0
    assert run([True] * 10 + [False] * 2 + [True] * 10).toggles == 1


def test_frames_without_a_hand_say_nothing_and_start_the_wait_again():
    assert run([True] * 3 + [None] * 20 + [True] * 3).toggles == 0
    assert run([True] * 10 + [None] * 20).is_open


def test_a_flat_hand_with_its_fingers_together_counts_nothing_and_spreading_them_does():
    state = OpenHand()
    for k, together in enumerate([True] * 20 + [False] * 20 + [True] * 20):
        estimate = ArmEstimate(
            k * FRAME_NS, TrackingStatus.TRACKED, "", wrist=np.zeros(3), hand_open=True, fingers_together=together
        )
        state = state.observe(estimate, GestureConfig())
        assert state.toggles == (0 if k < 20 + 3 else state.toggles)
    assert (state.toggles, state.is_open) == (1, False)


@settings(max_examples=30, deadline=None, derandomize=True)
@given(st.lists(st.sampled_from([True, False, None]), max_size=80))
def test_the_count_never_falls_and_rises_only_with_an_opening(observations):
    state = OpenHand()
    for k, seen in enumerate(observations):
        after = after_frame(state, k, seen)
        assert after.toggles - state.toggles == (1 if after.is_open and not state.is_open else 0)
        state = after
