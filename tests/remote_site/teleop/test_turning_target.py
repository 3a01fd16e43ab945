"""The tool's target as the hand turns: what the hand's certainty limits is limited of the tool, whatever the scale."""

import math

import numpy as np
import pytest

from common.clock import NS_PER_MS
from common.geometry import angle_between, rotation_from_quaternion, rotation_from_vector
from common.messages.hand import OperatorSettings
from remote_site.motion.catch_up import CATCH_UP_RAD_S
from remote_site.motion.config import ControlConfig
from remote_site.session.samples import Accepted
from remote_site.teleop.config import MappingConfig
from remote_site.teleop.tool_target import ToolTarget
from tests.remote_site.remote_loop import hand, workspace
from tests.remote_site.teleop.test_tool_target import BORN, MODEL, NOW, START, WRIST

PERIOD_NS, PERIOD_S = 33 * NS_PER_MS, 0.033
FREE = (math.inf, math.inf, math.inf)
SLOW = (math.radians(30.0),) * 3
NEVER = (0.0, 0.0, 0.0)
UNLEASHED = ControlConfig(leash_m=1.0, leash_deg=180.0)


def turned(k, degrees, turn_rad_s=FREE):
    """The k-th sample: a hand that has turned about the vertical, None if it shows no orientation."""
    born_ns = BORN + k * PERIOD_NS
    shown = rotation_from_vector(np.array([0.0, 0.0, math.radians(degrees)])) if degrees is not None else None
    return Accepted(hand(k, born_ns), WRIST, shown, born_ns, new_session=False, turn_rad_s=turn_rad_s)


def captured(settings=None, degrees=0.0):
    target = ToolTarget(MappingConfig(), UNLEASHED, workspace(), MODEL, START)
    target.capture(turned(0, degrees), settings or OperatorSettings(), START, 1)
    return target


def aimed(target, sample, settings=None):
    return target.aim(sample, settings or OperatorSettings(), START, START, NOW)


def deg(target):
    """How far the target has turned from the start."""
    return math.degrees(angle_between(MODEL.forward(START)[:3, :3], target.base_T_tool[:3, :3]))


@pytest.mark.parametrize("scale", [0.5, 1.0, 2.0])
def test_whatever_the_scale_of_rotation_the_tool_keeps_the_limit(scale):
    settings = OperatorSettings(rotation_scale=scale)
    target = captured(settings)
    aimed(target, turned(1, 20.0, SLOW), settings)
    assert deg(target) == pytest.approx(min(scale, 1.0) * 30.0 * PERIOD_S, rel=1e-6)


@pytest.mark.parametrize("scale", [1.0, 2.0])
def test_what_was_lacking_is_made_up_at_the_catch_up_speed_which_nothing_else_may_use_then(scale):
    settings = OperatorSettings(rotation_scale=scale)
    target = captured(settings)
    assert aimed(target, turned(1, 20.0, NEVER), settings).spare == 1.0
    assert aimed(target, turned(2, 20.0), settings).spare == pytest.approx(0.0)
    assert deg(target) == pytest.approx(math.degrees(CATCH_UP_RAD_S) * PERIOD_S, rel=1e-6)


def test_a_change_of_the_settings_takes_a_new_reference_so_nothing_is_made_up():
    target, renewed = captured(), OperatorSettings(revision=1)
    aimed(target, turned(1, 20.0, NEVER))
    for k in range(2, 60):
        aimed(target, turned(k, 20.0), renewed)
    assert deg(target) == pytest.approx(0.0, abs=1e-6)
    aimed(target, turned(60, 23.0), renewed)
    assert deg(target) == pytest.approx(3.0)


def test_a_capture_takes_a_new_reference_so_nothing_is_made_up():
    target = captured()
    aimed(target, turned(1, 20.0, NEVER))
    target.capture(turned(2, 20.0), OperatorSettings(), START, 2)
    for k in range(3, 60):
        aimed(target, turned(k, 20.0))
    assert deg(target) == pytest.approx(0.0, abs=1e-6)


def test_where_a_led_target_is_given_back_the_hand_goes_on_from_it_however_it_turned_meanwhile():
    target = captured()
    held = MODEL.forward(START)
    for k in range(1, 10):
        target.lead(held, turned(k, 3.0 * k, SLOW), START, START, NOW)
    target.rebase(turned(10, 30.0, SLOW), OperatorSettings())
    for k in range(11, 40):
        aimed(target, turned(k, 30.0, SLOW))
        assert deg(target) == pytest.approx(0.0, abs=1e-6)


def test_after_a_short_hold_it_goes_on_with_the_lag_from_before():
    target = captured()
    aimed(target, turned(1, 20.0, NEVER))
    assert target.resume(turned(5, 23.0), OperatorSettings(), START, BORN + PERIOD_NS)
    for k in range(6, 12):
        aimed(target, turned(k, 23.0, NEVER))
    assert 0.5 < deg(target) <= 3.0 + 1e-6  # the hold's own offset leads it to where the hand turned meanwhile


def test_the_published_reference_counts_for_the_orientation_that_the_samples_show():
    target = captured()
    aimed(target, turned(1, 20.0, NEVER))
    known = rotation_from_quaternion(target.reference.rotation.operator_R_hand)
    assert known == pytest.approx(turned(1, 20.0).operator_R_hand, abs=1e-9)
    aimed(target, turned(2, None))
    assert target.reference.rotation.operator_R_hand is None


def test_a_hand_that_showed_no_orientation_at_the_capture_turns_the_tool_from_its_first_one():
    target = captured(degrees=None)
    aimed(target, turned(1, 40.0))
    assert deg(target) == pytest.approx(0.0, abs=1e-6)
    aimed(target, turned(2, 43.0))
    assert deg(target) == pytest.approx(3.0)
