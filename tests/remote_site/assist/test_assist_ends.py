"""What ends a lead, and what counts as a marker that stands: by the assist itself, without a pipeline around it."""

import numpy as np
import pytest

from common.clock import NS_PER_MS
from common.geometry import Array, angle_between, rotation_from_vector, transform
from common.messages.robot import AssistPhase
from remote_site.assist.assist import Assist
from remote_site.assist.leading import step_towards
from remote_site.assist.standing_marker import StandingMarker
from remote_site.reasons import Code, Reason, reason
from tests.remote_site.assist.sightings import BLOCK, CONFIG, MARKER, PRESSED, RELEASED, refused, seen

MS = NS_PER_MS
BASE_T_MARKER = transform(np.eye(3), np.array([0.5, 0.0, 0.3]))
GOAL = BASE_T_MARKER @ BLOCK.marker_T_tool
HAND = np.zeros(3)


class Led:
    """A lead that has just begun, 20 mm beside the goal."""

    def __init__(self) -> None:
        self.assist, self.now_ns = Assist(CONFIG), 10_000 * MS
        self.tool = transform(GOAL[:3, :3], GOAL[:3, 3] + (0.0, 0.02, 0.0))
        for _ in range(20):
            self.sample(RELEASED)
        self.sample(PRESSED)
        assert self.phase is AssistPhase.LEADING

    def sample(self, intent: object, hand: Array = HAND) -> None:
        """40 ms later the marker is seen, and a sample is followed."""
        self.now_ns += 40 * MS
        self.assist.see((seen(self.now_ns, BASE_T_MARKER),))
        self.assist.observe_intent(intent, self.now_ns)  # type: ignore[arg-type]
        self.assist.tick(self.now_ns)
        self.assist.step(hand, self.now_ns, self.tool, self.tool, self.now_ns, True)

    @property
    def phase(self) -> AssistPhase:
        state = self.assist.state()
        assert state is not None
        return state.phase

    @property
    def said(self) -> tuple[str, str]:
        state = self.assist.state()
        assert state is not None
        return state.code, state.reason


def test_a_page_that_reports_nothing_any_more_ends_it_with_how_long() -> None:
    led = Led()
    for after_ms, phase in ((200, AssistPhase.LEADING), (204, AssistPhase.ENDED)):
        led.assist.see((seen(led.now_ns + after_ms * MS, BASE_T_MARKER),))
        led.assist.tick(led.now_ns + after_ms * MS)
        assert led.phase is phase
    assert led.said == (Code.ASSIST_SILENT, "the assist has ended: the page reported nothing for 204 ms")


def test_a_hand_that_moves_ends_it_with_how_far() -> None:
    led = Led()
    led.sample(PRESSED, np.array([0.0, 1.5, 2.0]))
    assert led.said == (Code.ASSIST_MOVED, "the assist has ended: the hand moved by 2500 mm")


def test_no_step_goes_beyond_the_goal_however_long_it_takes() -> None:
    here = transform(rotation_from_vector(np.array([0.1, 0.0, 0.2])) @ GOAL[:3, :3], GOAL[:3, 3] + (0.002, 0.0, 0.001))
    for elapsed_s in (2.0, 5.0, 60.0):
        there = step_towards(here, GOAL, np.array([0.0, 1.0, 0.0]), elapsed_s, 10.0)
        assert there[:3, 3] == pytest.approx(GOAL[:3, 3], abs=1e-9)
        assert angle_between(there[:3, :3], GOAL[:3, :3]) == pytest.approx(0.0, abs=1e-6)


def code(known: object) -> Code:
    assert isinstance(known, Reason)
    return known.code


def test_a_marker_stands_once_it_was_seen_for_300_ms_and_three_times() -> None:
    marker = StandingMarker(MARKER)
    for after_ms in (0, 100, 200, 299):
        marker.see(seen((5000 + after_ms) * MS, BASE_T_MARKER))
        assert code(marker.pose((5000 + after_ms) * MS)) is Code.ASSIST_STEADYING
    marker.see(seen(5300 * MS, BASE_T_MARKER))
    assert isinstance(marker.pose(5300 * MS), tuple)
    rarely = StandingMarker(MARKER)
    for after_ms in (0, 400):
        rarely.see(seen((5000 + after_ms) * MS, BASE_T_MARKER))
        assert code(rarely.pose((5000 + after_ms) * MS)) is Code.ASSIST_STEADYING


def test_what_was_seen_of_a_marker_too_long_ago_is_told_with_its_age() -> None:
    marker = StandingMarker(MARKER)
    for after_ms in (0, 200, 400):
        marker.see(seen((5000 + after_ms) * MS, BASE_T_MARKER))
    assert isinstance(marker.pose(6100 * MS), tuple)
    stale = marker.pose(6101 * MS)
    assert code(stale) is Code.MARKER_STALE
    assert isinstance(stale, Reason)
    assert "are 701 ms old" in stale.sentence


def test_a_round_of_pictures_that_misses_the_marker_does_not_count_before_half_a_second() -> None:
    marker = StandingMarker(MARKER)
    for after_ms in (0, 200, 400):
        marker.see(seen((5000 + after_ms) * MS, BASE_T_MARKER))
    marker.see(refused(5800 * MS, reason(Code.MARKER_UNSEEN, marker=MARKER)))
    assert isinstance(marker.pose(5900 * MS), tuple)
    assert code(marker.pose(5901 * MS)) is Code.MARKER_UNSEEN
