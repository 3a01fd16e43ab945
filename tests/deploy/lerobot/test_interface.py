"""The package as LeRobot asks for it: names, types, dependencies, and the layout of Farhand's messages in it."""

import inspect
import tomllib

import msgpack
import pytest
from lerobot.teleoperators.config import TeleoperatorConfig
from lerobot.teleoperators.teleoperator import Teleoperator
from lerobot_teleoperator_farhand import FarhandTeleop, FarhandTeleopConfig, wire

import tests.common.messages.golden_examples as golden
from common.messages.base import PROTOCOL_VERSION
from common.messages.codec import encode
from common.messages.requests import ClockAnswer, Description
from common.messages.robot import GripperCommand, RobotState, SessionState
from tests.deploy.lerobot.conftest import PACKAGE

MEMBERS = {
    "action_features", "feedback_features", "is_connected", "connect", "is_calibrated", "calibrate", "configure",
    "get_action", "send_feedback", "disconnect",
}  # fmt: skip
JOINTS = ["joint_1", "joint_2"]


def test_it_is_found_by_its_name_and_depends_on_two_packages():
    project = tomllib.loads((PACKAGE / "pyproject.toml").read_text())["project"]
    assert project["name"] == "lerobot_teleoperator_farhand" == FarhandTeleop.__module__.split(".")[0]
    assert [one.partition(">")[0] for one in project["dependencies"]] == ["eclipse-zenoh", "msgpack"]
    assert "lerobot itself was not run" in (PACKAGE / "README.md").read_text().lower().replace("\n", " ")


def test_every_abstract_member_is_there_with_its_signature():
    assert Teleoperator.__abstractmethods__ == MEMBERS
    assert FarhandTeleop.__abstractmethods__ == frozenset()
    for name in MEMBERS:
        theirs, ours = getattr(Teleoperator, name), getattr(FarhandTeleop, name)
        assert isinstance(ours, property) is isinstance(theirs, property)
        if not isinstance(ours, property):
            assert list(inspect.signature(ours).parameters) == list(inspect.signature(theirs).parameters)
    assert FarhandTeleop.config_class is FarhandTeleopConfig
    assert TeleoperatorConfig.choices[FarhandTeleop.name] is FarhandTeleopConfig
    assert FarhandTeleopConfig.__name__ == FarhandTeleop.__name__ + "Config"  # how LeRobot gets from one to the other


@pytest.mark.parametrize("gripper", [True, False])
def test_features_are_known_before_it_is_connected(gripper):
    joints = FarhandTeleop(FarhandTeleopConfig(joints=JOINTS, gripper=gripper))
    assert joints.action_features == {"joint_1.pos": float, "joint_2.pos": float} | (
        {"gripper.pos": float} if gripper else {}
    )
    tool = FarhandTeleop(FarhandTeleopConfig(action="tool", gripper=gripper))
    assert len(tool.action_features) == 7 + gripper
    assert joints.feedback_features == {}
    assert joints.is_calibrated
    assert not joints.is_connected


def test_what_is_configured_wrongly_is_refused_with_the_cure():
    for wrong, cure in (
        ({}, "name the cell's joints"),
        ({"action": "hand"}, "write 'joints' or 'tool'"),
        ({"joints": JOINTS, "ca": "ca.pem"}, "give all three"),
        ({"joints": JOINTS, "remote": "tls/robot.example.org:7447"}, "needs certificates"),
        ({"joints": JOINTS, "remote": "tcp/robot.example.org:7447"}, "anybody on the network could move your robot"),
        ({"joints": JOINTS, "remote": "udp/127.0.0.1:7447"}, "write tls/HOST:PORT"),
        ({"joints": JOINTS, "ca": "a", "certificate": "c", "key": "k"}, "uses no certificates"),
    ):
        with pytest.raises(ValueError, match=cure):
            FarhandTeleopConfig(**wrong)


def test_a_state_may_have_more_fields_at_its_end_and_not_fewer():
    fields = msgpack.unpackb(encode(golden.STATE))
    assert wire.cell_state(msgpack.packb([*fields, 7])) == wire.cell_state(encode(golden.STATE))
    with pytest.raises(wire.WireError, match="too few: install the release of the cell"):
        wire.cell_state(msgpack.packb(fields[: wire.TARGET + 1]))


def test_the_layout_of_messages_is_that_of_this_release():
    assert wire.VERSION == PROTOCOL_VERSION
    fields = RobotState.__struct_fields__
    named = {
        "session": wire.SESSION, "seq": wire.SEQ, "t_ns": wire.T_NS, "state": wire.STATE, "code": wire.CODE,
        "reason": wire.REASON, "q_commanded": wire.Q_COMMANDED, "base_T_tool": wire.BASE_T_TOOL,
        "gripper": wire.GRIPPER, "gripper_next": wire.GRIPPER_NEXT, "target": wire.TARGET,
    }  # fmt: skip
    assert {name: fields.index(name) for name in named} == named
    assert tuple(SessionState) == wire.STATES
    assert list(GripperCommand)[wire.OPENS_NEXT] is GripperCommand.OPEN
    assert Description.__struct_fields__[wire.JOINTS_OF_CELL] == "joints"
    assert ClockAnswer.__struct_fields__ == ("received_ns", "answered_ns", "ahead_ns")


def test_messages_are_read_as_farhand_writes_them():
    state = wire.cell_state(encode(golden.STATE))
    assert (state.t_ns, state.state, state.reason) == (golden.STATE.t_ns, golden.STATE.state, golden.STATE.reason)
    assert state.q == pytest.approx(golden.STATE.q_commanded, abs=1e-6)
    aim = golden.STATE.target or golden.STATE.base_T_tool
    assert state.tool == pytest.approx((*aim.position, *aim.orientation), abs=1e-6)
    assert state.is_open is (golden.STATE.gripper_next is not GripperCommand.OPEN)
    assert wire.joint_names(encode(golden.DESCRIPTION)) == [joint.name for joint in golden.DESCRIPTION.joints]
    assert wire.clock_times(encode(ClockAnswer(received_ns=3, answered_ns=4, ahead_ns=-5))) == (3, 4, -5)


@pytest.mark.parametrize("payload", [b"", b"\xc1", b"\x80", b"\x91\x0b", b"\x91\x0c", b"\x00" * 20_000])
def test_what_is_no_state_is_refused(payload):
    with pytest.raises(wire.WireError):
        wire.cell_state(payload)
