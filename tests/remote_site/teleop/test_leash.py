"""The leash: no target is farther ahead of the arm than it allows, and no reading leads one astray."""

import numpy as np
import pytest

from common.geometry import Array, angle_between, rotation_from_vector, transform, vector_from_rotation
from remote_site.reasons import Code
from remote_site.teleop.tool_target import Leash

TOOL = transform(rotation_from_vector(np.array([0.2, 0.4, 0.1])), np.array([0.4, 0.1, 0.8]))
LEASH = Leash(0.2, 1.0)


def moved(way: tuple[float, float, float], turn: float = 0.0, from_pose: Array = TOOL) -> Array:
    """A pose that is `way` m away, and turned by `turn` rad about its own y."""
    turned = from_pose[:3, :3] @ rotation_from_vector(np.array([0.0, turn, 0.0]))
    return transform(turned, from_pose[:3, 3] + way)


def held(wanted: Array, former: Array = TOOL, sent: Array = TOOL, measured: Array = TOOL) -> Array:
    return LEASH.hold(wanted, former, sent, measured)[0]


def way_m(a: Array, b: Array = TOOL) -> float:
    return float(np.linalg.norm(a[:3, 3] - b[:3, 3]))


def test_a_target_far_ahead_is_drawn_towards_the_arm() -> None:
    target, why = LEASH.hold(moved((0.0, 3.0, 0.0), 0.2), TOOL, TOOL, TOOL)
    assert target[:3, 3] - TOOL[:3, 3] == pytest.approx([0.0, 0.2, 0.0])
    assert why is not None
    assert why.code is Code.SATURATED
    assert "3000 mm ahead of the arm and held at 200 mm" in why.sentence
    assert np.linalg.norm(vector_from_rotation(TOOL[:3, :3].T @ target[:3, :3])) < 0.2


def test_a_target_that_is_turned_far_ahead_is_held_too() -> None:
    target, why = LEASH.hold(moved((0.0, 0.0, 0.0), 2.0), TOOL, TOOL, TOOL)
    assert vector_from_rotation(TOOL[:3, :3].T @ target[:3, :3]) == pytest.approx([0.0, 1.0, 0.0])
    assert why is not None


def test_a_near_target_is_as_it_is_wanted() -> None:
    near = moved((0.05, 0.05, 0.05))
    assert LEASH.hold(near, TOOL, TOOL, TOOL) == (near, None)


@pytest.mark.parametrize("off", [(0.6, 0.0, 0.0), (0.0, -0.6, 0.1), (0.3, 0.3, 0.3), (0.0, 0.0, 0.21)])
@pytest.mark.parametrize("turn", [0.0, 2.0])
def test_a_wrong_reading_leads_no_target_anywhere(off: tuple[float, float, float], turn: float) -> None:
    """The hand rests, or moves on: the target stays on the way from the one before."""
    assert held(TOOL, measured=moved(off, turn)) == pytest.approx(TOOL)
    wanted = moved((0.0, 0.02, 0.0))
    target = held(wanted, measured=moved(off, turn))
    assert way_m(target, TOOL) + way_m(target, wanted) == pytest.approx(0.02)
    assert way_m(target, moved(off)) <= way_m(TOOL, moved(off)) + 1e-9


def test_a_reading_that_is_ahead_of_the_arm_lets_the_target_lead_no_farther() -> None:
    assert way_m(held(moved((0.0, 1.0, 0.0)), measured=moved((0.0, 0.3, 0.0)))) == pytest.approx(0.2, abs=1e-3)


def test_an_arm_that_stands_still_holds_the_target_within_the_leash_wherever_it_is_sent() -> None:
    former, sent = TOOL, TOOL
    for k in range(100):
        former = held(moved((0.0, 0.02 * k, 0.0)), former, sent)
        sent = former
    assert way_m(former) == pytest.approx(0.2, rel=1e-3)
    assert way_m(former) <= 0.2 + 1e-9
    why = LEASH.hold(moved((0.0, 0.3, 0.0)), former, sent, TOOL)[1]
    assert why is not None
    assert why.sentence == "the target is 300 mm ahead of the arm and held at 200 mm"


def test_the_way_back_to_an_arm_that_stands_still_is_open() -> None:
    far, back = moved((0.0, 0.2, 0.0)), moved((0.0, 0.15, 0.0))
    assert held(back, far, far) is back


def test_an_arm_that_lags_is_waited_for_and_led_on() -> None:
    """It is where it was sent 250 ms ago, and sent on at 1 m/s."""
    sent = [TOOL] * 60
    for k in range(120):
        wanted = moved((0.0, 0.004 * k, 0.0))
        sent.append(held(wanted, sent[-1], sent[-1], sent[-60]))
        assert way_m(sent[-1], sent[-61]) <= 0.2 + 0.004 + 1e-9
    assert way_m(sent[-1]) > 0.3


def test_a_far_target_can_be_moved_sideways_where_the_arm_gets_no_nearer_to_it() -> None:
    arm = moved((0.0, 0.0, 0.0))
    former = held(moved((0.0, 2.0, 0.0)))
    for k in range(1, 30):
        former = held(moved((0.05 * k, 2.0, 0.0)), former, arm, arm)
    ahead = former[:3, 3] - arm[:3, 3]
    assert ahead / np.linalg.norm(ahead) == pytest.approx(np.array([1.45, 2.0, 0.0]) / np.hypot(1.45, 2.0), abs=1e-6)
    assert angle_between(former[:3, :3], TOOL[:3, :3]) == pytest.approx(0.0, abs=1e-6)
