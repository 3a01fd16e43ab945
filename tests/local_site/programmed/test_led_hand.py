"""The hand that leads the tool: the remote site's mapping takes it exactly where it should."""

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from msgspec.structs import replace
from scipy.spatial.transform import Rotation

from common.errors import ConfigError
from common.geometry import transform
from common.mapping.relative_mapping import RelativeMapping
from common.mapping.shown_hand import shown_orientation
from common.messages.hand import Locks, OperatorSettings, TrackingStatus
from common.messages.requests import MappingDescription
from local_site.programmed.led_hand import operator_T_hand, shown_hand, why_not_led
from local_site.samples.hand_sample import HandSampler, OpenHand
from remote_site.teleop.config import MappingConfig
from tests.present import present

CONFIG = MappingConfig()
MAPPING = MappingDescription(
    point=CONFIG.point,
    scale=0.8,
    scale_range=CONFIG.scale_range,
    base_R_operator=CONFIG.base_R_operator,
    locks=Locks(),
)
COORDINATE = st.floats(-0.5, 0.5)
TURN = st.tuples(*[st.floats(-1.5, 1.5)] * 3)
PLACE = st.tuples(*[COORDINATE] * 3)


def pose(place, turn):
    return transform(Rotation.from_rotvec(turn).as_matrix(), np.array(place))


def sample_of(operator_T_hand):
    hand = shown_hand(operator_T_hand, 1, TrackingStatus.TRACKED, "")
    return HandSampler(1).sample(hand, OpenHand(), 1, None, None, 1)


@settings(max_examples=60, deadline=None)
@given(PLACE, TURN, PLACE, TURN, PLACE, TURN, st.floats(0.2, 2.0), st.floats(0.5, 2.0))
def test_the_mapping_takes_the_hand_to_the_pose(at, turned, tool_at, tool_turned, to, to_turned, scale, turn_scale):
    assume(0.9 * np.linalg.norm(to_turned) / turn_scale < 3.0)  # more than half a turn of the hand needs steps between
    in_force = OperatorSettings(lease=1, revision=3, scale=scale, rotation_scale=turn_scale)
    mapping, first, base_T_tool = RelativeMapping(MAPPING), pose(at, turned), pose(tool_at, tool_turned)
    mapping.engage(first[:3, 3], first[:3, :3], base_T_tool)
    mapping.steer(in_force, first[:3, 3], first[:3, :3], base_T_tool)
    reference = present(mapping.reference(sample_of(first), np.eye(3)))
    wanted = transform(Rotation.from_rotvec(0.9 * np.array(to_turned)).as_matrix() @ base_T_tool[:3, :3], np.array(to))
    hand = operator_T_hand(wanted, MAPPING, in_force, reference)
    reached = mapping.target(hand[:3, 3], hand[:3, :3])
    assert reached == pytest.approx(wanted, abs=1e-9)


@given(PLACE, TURN)
def test_the_points_show_the_hands_pose(at, turned):
    operator_T_led = pose(at, turned)
    sample = sample_of(operator_T_led)
    assert shown_orientation(sample) == pytest.approx(operator_T_led[:3, :3], abs=1e-12)
    assert sample.wrist == sample.palm == pytest.approx(operator_T_led[:3, 3])


def test_a_hand_that_showed_no_orientation_leads_nowhere():
    mapping = RelativeMapping(MAPPING)
    mapping.engage(np.zeros(3), None, np.eye(4))
    with pytest.raises(ConfigError, match="engage again"):
        operator_T_hand(np.eye(4), MAPPING, OperatorSettings(), present(mapping.reference(sample_of(np.eye(4)), None)))


def test_locks_and_a_rotation_that_is_switched_off_are_refused_by_name():
    assert why_not_led(MAPPING, OperatorSettings()) == ""
    assert "roll is locked on the page" in why_not_led(MAPPING, OperatorSettings(locks=Locks(roll=True)))
    assert "mapping.locks" in why_not_led(replace(MAPPING, locks=Locks(x=True)), OperatorSettings())
    assert "rotation" in why_not_led(MAPPING, OperatorSettings(rotation_scale=0.0))
