"""Fine adjustment through the whole pipeline: the tool is led slowly to the pose, and no end of it moves the tool."""

import itertools
import math
from typing import Any

import numpy as np
import pytest
from msgspec.structs import replace

from common.geometry import Array, angle_between, inverse, rotation_from_vector, transform
from common.messages.hand import Intent, TrackingStatus
from common.messages.robot import AssistPhase, SessionState
from remote_site.assist.sighting import MarkerSighting
from remote_site.config import RemoteConfig
from remote_site.reasons import Code, Reason, reason
from tests.present import present
from tests.remote_site.assist.sightings import BLOCK, CONFIG, MARKER, PRESSED, RELEASED, refused, seen
from tests.remote_site.remote_loop import Point, RemoteLoop, assert_within_limits, hand

EVERY, SEEN_EVERY = 8, 30  # ticks of 4 ms between samples, and between sightings
HAND = (0.0, 0.0, 0.3)


class AssistLoop(RemoteLoop):
    """The pipeline with a target beside the tool, whose marker is seen eight times a second."""

    def __init__(self, way_m: Point = (-0.03, -0.02, 0.015), turn_rad: Point = (0.0, 0.1, 0.15), **safety: Any) -> None:
        video = replace(RemoteConfig().video, calibrated=True)
        guarded = replace(RemoteConfig().safety, **safety)
        super().__init__(replace(RemoteConfig(), assist=CONFIG, video=video, safety=guarded))
        tool = self.model.forward(self.sent.q)
        self.goal = transform(rotation_from_vector(np.array(turn_rad)) @ tool[:3, :3], tool[:3, 3] + way_m)
        self.base_T_marker = self.goal @ inverse(BLOCK.marker_T_tool)
        self.refusal: Reason | None = None
        self.targets, self.phases = list[Array](), list[AssistPhase]()
        self.ticks = 0

    def go(self, seconds: float, intent: Intent | None = RELEASED, place: Point = HAND, **changes: Any) -> None:
        """Run with a hand at one place, and the page's intent in every sample."""
        for _ in range(round(seconds * 250)):
            self.ticks += 1
            now_ns = self.clock.now_ns()
            samples, markers = [], list[MarkerSighting]()
            if self.ticks % EVERY == 0:
                self.hand_seq += 1
                samples = [hand(self.hand_seq, now_ns, place, lease=self.lease, intent=intent, **changes)]
            if self.ticks % SEEN_EVERY == 0:
                markers = [self.sighting(now_ns)]
            self.tick(*samples, markers=tuple(markers))
            self.targets.append(self.snapshot.target.copy())
            self.phases.append(present(self.snapshot.assist).phase)

    def sighting(self, now_ns):
        if self.refusal is not None:
            return refused(now_ns, self.refusal)
        return seen(now_ns - 60_000_000, self.base_T_marker)

    @property
    def tool(self):
        return self.model.forward(self.sent.q)

    @property
    def assist(self):
        return self.snapshot.assist

    def miss(self):
        """How far the commanded tool is from the pose, mm and deg."""
        angle = angle_between(self.tool[:3, :3], self.goal[:3, :3])
        return 1e3 * math.dist(self.tool[:3, 3], self.goal[:3, 3]), math.degrees(angle)


def offered(**changes: Any) -> AssistLoop:
    loop = AssistLoop(**changes)
    loop.go(2.5)
    assert loop.snapshot.state is SessionState.ENGAGED
    assert loop.assist.phase is AssistPhase.OFFERED, loop.assist
    return loop


def leading() -> AssistLoop:
    loop = offered()
    loop.go(0.5, PRESSED)
    assert loop.assist.phase is AssistPhase.LEADING
    return loop


def largest_step(targets):
    return max(1e3 * math.dist(a[:3, 3], b[:3, 3]) for a, b in itertools.pairwise(targets))


def test_the_offer_says_what_it_will_do_before_it_does_it():
    loop = offered()
    assert loop.assist.reason == "hold Assist: the tool will move 39 mm and 10 deg to grasp 'block'"
    assert loop.assist.target.base_T_tool.transform() == pytest.approx(loop.goal, abs=1e-6)
    assert loop.miss()[0] > 38


def test_the_tool_is_led_to_the_pose_within_both_speeds_and_stays_there():
    loop = offered()
    begin = len(loop.log)
    loop.go(4.0, PRESSED)
    assert max(loop.miss()) < 0.05
    assert loop.assist.code == Code.ASSIST_THERE
    tools = [loop.model.forward(motion.q) for motion in loop.log[begin::5]]
    speeds = [math.dist(a[:3, 3], b[:3, 3]) / 0.02 for a, b in itertools.pairwise(tools)]
    turns = [angle_between(a[:3, :3], b[:3, :3]) / 0.02 for a, b in itertools.pairwise(tools)]
    assert 0.025 < max(speeds) <= 0.030
    assert max(turns) <= math.radians(10.0)
    assert_within_limits(loop)


def test_after_letting_go_the_hand_leads_from_where_the_tool_is():
    loop = offered()
    loop.go(4.0, PRESSED)
    there = loop.tool
    loop.go(0.5)
    assert loop.assist.phase is AssistPhase.ENDED or loop.assist.code == Code.ASSIST_OFFERED
    assert loop.tool == pytest.approx(there, abs=1e-5)
    loop.go(2.0, place=(0.0, 0.02, 0.3))
    moved = loop.tool[:3, 3] - there[:3, 3]
    assert np.linalg.norm(moved) == pytest.approx(0.02, abs=1e-3)


def test_letting_go_ends_it_with_the_next_sample():
    loop = leading()
    left = loop.miss()[0]
    loop.go(0.04)
    assert loop.assist.code == Code.ASSIST_LET_GO
    loop.go(1.0)
    assert loop.miss()[0] > left - 4
    assert loop.miss()[0] > 5


def test_the_hand_moved_by_less_leaves_it_and_by_more_ends_it():
    loop = leading()
    loop.go(0.1, PRESSED, (0.0, 0.014, 0.3))
    assert loop.assist.phase is AssistPhase.LEADING
    before = len(loop.targets) - 1
    loop.go(0.1, PRESSED, (0.0, 0.016, 0.3))
    assert loop.assist.code == Code.ASSIST_MOVED
    assert largest_step(loop.targets[before:]) < 1.5
    loop.go(1.0, PRESSED, (0.0, 0.016, 0.3))
    assert loop.assist.phase is AssistPhase.ENDED, "held on, the key begins nothing"


def test_a_silent_page_ends_it_and_a_key_still_held_begins_nothing():
    loop = leading()
    loop.go(0.1, None)
    assert loop.assist.phase is AssistPhase.ENDED
    loop.go(2.0, PRESSED)
    assert AssistPhase.LEADING not in loop.phases[-400:]
    loop.go(1.0, RELEASED)
    loop.go(0.2, PRESSED)
    assert loop.assist.phase is AssistPhase.LEADING


def test_samples_that_stay_away_end_it():
    loop = leading()
    for _ in range(52):
        loop.tick()
    assert loop.assist.phase is AssistPhase.ENDED


def test_a_hold_ends_it_and_the_arm_goes_on_from_new_origins():
    loop = leading()
    loop.go(0.1, PRESSED, status=TrackingStatus.LOST)
    assert loop.snapshot.state is SessionState.HOLDING
    assert loop.assist.code in (Code.ASSIST_HALTED, Code.ASSIST_LET_GO)
    rested = loop.tool
    loop.go(1.5)
    assert loop.snapshot.state is SessionState.ENGAGED
    assert 1e3 * math.dist(loop.tool[:3, 3], rested[:3, 3]) < 2.0
    assert AssistPhase.LEADING not in loop.phases[-300:]


def test_a_short_hold_while_it_leads_takes_nothing_back_of_where_it_led_the_tool():
    loop = leading()
    for _ in range(48):
        loop.tick()
    assert loop.snapshot.state is SessionState.HOLDING
    assert loop.snapshot.reference is None, "the hand led the tool no more: there is nothing to go back to"
    rested = loop.tool
    assert math.dist(rested[:3, 3], loop.model.forward(loop.config.robot.start)[:3, 3]) > 0.005
    loop.go(1.5)
    assert loop.snapshot.state is SessionState.ENGAGED
    assert 1e3 * math.dist(loop.tool[:3, 3], rested[:3, 3]) < 0.5


@pytest.mark.parametrize(
    ("why", "within_s"),
    [
        (reason(Code.MARKER_UNSEEN, marker=MARKER), 0.6),
        (reason(Code.MARKER_DOUBLED, marker=MARKER, view="side"), 0.15),
    ],
)
def test_a_marker_that_is_covered_or_doubled_ends_it_with_the_reason(why, within_s):
    loop = leading()
    loop.refusal = why
    loop.go(within_s, PRESSED)
    assert loop.assist.code == Code.ASSIST_LOST
    assert why.sentence in loop.assist.reason
    loop.go(1.0)
    assert loop.assist.phase is AssistPhase.OFF
    assert loop.assist.reason == why.sentence


def test_a_marker_moved_by_hand_ends_it():
    loop = leading()
    loop.base_T_marker = transform(np.eye(3), np.array([0.006, 0.0, 0.0])) @ loop.base_T_marker
    loop.go(0.2, PRESSED)
    assert loop.assist.code == Code.ASSIST_LOST
    assert "has moved by 6 mm" in loop.assist.reason


@pytest.mark.parametrize("way_m", [(0.062, 0, 0), (0, 0, -0.08)])
def test_a_pose_out_of_reach_is_not_offered(way_m):
    loop = AssistLoop(way_m, (0, 0, 0))
    loop.go(2.5)
    assert loop.assist.code == Code.ASSIST_FAR
    loop.go(1.0, PRESSED)
    assert AssistPhase.LEADING not in loop.phases
    assert loop.assist.target.name == BLOCK.name


def test_a_pose_outside_the_box_is_given_up_where_the_tool_comes_no_nearer():
    x, y, z = RemoteConfig().safety.workspace_max_m
    tool_x = AssistLoop().tool[0, 3]
    loop = offered(way_m=(0.05, 0.0, 0.0), workspace_max_m=(min(x, tool_x + 0.02), y, z))
    loop.go(5.0, PRESSED)
    assert AssistPhase.LEADING in loop.phases
    assert loop.assist.code == Code.ASSIST_STUCK
    assert "30 mm" in loop.assist.reason
    assert loop.tool[0, 3] < tool_x + 0.021
    before = loop.tool
    loop.go(1.0)
    assert loop.tool == pytest.approx(before, abs=1e-3)


def test_a_pose_turned_by_more_than_20_deg_is_not_offered():
    loop = AssistLoop((0.01, 0, 0), (0, 0, math.radians(21)))
    loop.go(2.5)
    assert loop.assist.code == Code.ASSIST_FAR
    assert "21 deg away" in loop.assist.reason


def test_a_key_that_was_down_before_the_offer_or_names_another_target_begins_nothing():
    loop = AssistLoop()
    loop.go(3.0, PRESSED)
    assert AssistPhase.LEADING not in loop.phases
    loop = offered()
    loop.go(1.0, Intent(assist="shelf"))
    assert AssistPhase.LEADING not in loop.phases


def test_without_targets_there_is_no_assist():
    loop = RemoteLoop()
    loop.run(300, lambda _t: HAND, intent=PRESSED)
    assert loop.snapshot.assist is None
