"""Actions from a cell over Zenoh: live ones, and none that is stale."""

import time
from datetime import UTC, datetime

import msgspec
import pytest
from lerobot.utils.errors import DeviceAlreadyConnectedError, DeviceNotConnectedError
from lerobot_teleoperator_farhand import FarhandTeleop, FarhandTeleopConfig
from lerobot_teleoperator_farhand.feed import StaleDataError

import tests.common.messages.golden_examples as golden
from common.messages.robot import GripperCommand, SessionState
from farhand.certificates.folder import CertificateOrder, create
from tests.deploy.lerobot.conftest import CELL, CELL_STATE

JOINTS = [joint.name for joint in golden.DESCRIPTION.joints]
PATIENCE_S, GENEROUS_MS = 20.0, 10_000.0


def teleop(cell, **given):
    config = {"joints": JOINTS, "max_age_ms": GENEROUS_MS} | given
    return FarhandTeleop(FarhandTeleopConfig(cell=CELL, remote=cell.endpoint, **config))


def action(device):
    """The first action that is live."""
    until = time.monotonic() + PATIENCE_S
    while True:
        try:
            return device.get_action()
        except StaleDataError:
            if time.monotonic() > until:
                raise
            time.sleep(0.02)


def refusal(device, words):
    """The first refusal for this reason."""
    until = time.monotonic() + PATIENCE_S
    while time.monotonic() < until:
        try:
            device.get_action()
        except StaleDataError as error:
            if words in str(error):
                return str(error)
        time.sleep(0.02)
    raise AssertionError(f"never refused: {words}")


@pytest.fixture
def connected(published):
    device = teleop(published)
    device.connect()
    yield device
    if device.is_connected:
        device.disconnect()


def test_joints_and_gripper_are_what_the_hand_commands(connected, published):
    state = CELL_STATE
    published.state = msgspec.structs.replace(state, gripper_next=GripperCommand.CLOSED)
    first = action(connected)
    assert list(first) == list(connected.action_features)
    assert [first[f"{name}.pos"] for name in JOINTS] == pytest.approx(state.q_commanded, abs=1e-6)
    assert all(type(value) is float for value in first.values())
    assert first["gripper.pos"] == 1.0
    published.state = msgspec.structs.replace(state, gripper_next=GripperCommand.OPEN)
    until = time.monotonic() + PATIENCE_S
    while action(connected)["gripper.pos"] != 0.0:
        assert time.monotonic() < until


def test_the_tool_is_the_target_while_the_arm_follows_else_where_it_is(published):
    device = teleop(published, action="tool", gripper=False)
    aim = msgspec.structs.replace(golden.POSE, position=(0.25, 0.5, 0.75))
    published.state = msgspec.structs.replace(CELL_STATE, target=aim)
    device.connect()
    try:
        assert list(action(device).values())[:3] == [0.25, 0.5, 0.75]
    finally:
        device.disconnect()
    published.state = msgspec.structs.replace(CELL_STATE, target=None, base_T_tool=golden.POSE)
    device.connect()
    try:
        assert list(action(device).values()) == pytest.approx([*golden.POSE.position, *golden.POSE.orientation])
    finally:
        device.disconnect()


def test_a_state_that_is_old_by_the_cells_clock_is_refused_although_it_came_just_now(connected, published):
    action(connected)
    published.late_ns = 60 * 10**9
    assert "the newest state is up to 60" in refusal(connected, "ms old, at most")
    published.late_ns = 0
    action(connected)


@pytest.mark.slow
def test_silence_is_refused_as_soon_as_the_last_state_is_too_old(published):
    device = teleop(published, max_age_ms=2_000.0)
    device.connect()
    try:
        action(device)
        published.state = None
        refusal(device, "ms old, at most")
    finally:
        device.disconnect()


def test_an_unknown_age_is_no_young_one(published):
    published.tells_time = False
    device = teleop(published)
    device.connect()
    try:
        refusal(device, "the age of its state is unknown")
        published.tells_time = True
        action(device)
    finally:
        device.disconnect()


def test_a_fault_is_refused_with_its_reason(connected, published):
    action(connected)
    published.state = msgspec.structs.replace(CELL_STATE, state=SessionState.FAULT, reason="a joint does not follow")
    refusal(connected, "a joint does not follow")


def test_before_and_after_the_connection_nothing_is_given(published):
    device = teleop(published)
    with pytest.raises(DeviceNotConnectedError, match="call connect"):
        device.get_action()
    device.connect(calibrate=False)
    with pytest.raises(DeviceAlreadyConnectedError):
        device.connect()
    device.send_feedback({})
    with pytest.raises(ValueError, match="feels nothing"):
        device.send_feedback({"force": 1.0})
    device.disconnect()
    assert not device.is_connected
    with pytest.raises(DeviceNotConnectedError):
        device.disconnect()


def test_a_cell_with_other_joints_or_that_does_not_answer_is_refused_with_the_cure(published):
    with pytest.raises(ConnectionError, match=f"the cell has the joints {JOINTS[0]}.* set joints"):
        teleop(published, joints=["other"]).connect()
    silent = FarhandTeleopConfig(cell="none", remote=published.endpoint, action="tool", connect_timeout_s=0.5)
    with pytest.raises(ConnectionError, match="nobody answers for cell 'none'"):
        FarhandTeleop(silent).connect()


@pytest.mark.slow
def test_with_certificates_a_viewers_suffices(secured_cell, tmp_path):
    endpoint, folder = secured_cell.endpoint, tmp_path / "pki"
    pair = folder / CELL / "viewer"
    given = {"ca": f"{folder}/viewers-ca.pem", "certificate": f"{pair}.pem", "key": f"{pair}.key"}
    assert endpoint.startswith("tls/")
    device = teleop(secured_cell, **given)
    device.connect()
    try:
        assert list(action(device)) == list(device.action_features)
    finally:
        device.disconnect()
    create(tmp_path / "foreign", CertificateOrder(CELL, (), 30, ("anna",)), datetime.now(UTC))
    foreign = {name: path.replace("/pki/", "/foreign/") for name, path in given.items()}
    with pytest.raises(ConnectionError, match="do the certificates belong to it"):
        teleop(secured_cell, connect_timeout_s=0.5, **foreign).connect()


def test_an_operators_certificate_asks_on_keys_of_its_own(secured_cell, tmp_path):
    pair = tmp_path / "pki" / CELL / "operator.anna"
    secured_cell.endpoint = secured_cell.control
    device = teleop(secured_cell, ca=f"{tmp_path}/pki/ca.pem", certificate=f"{pair}.pem", key=f"{pair}.key")
    device.connect()
    try:
        assert list(action(device)) == list(device.action_features)
    finally:
        device.disconnect()


@pytest.mark.parametrize("words", [None, "no certificate"])
def test_a_certificate_that_cannot_be_read_is_named(secured_cell, tmp_path, words):
    path = tmp_path / "operator.pem"
    if words is not None:
        path.write_text(words)
    with pytest.raises(ConnectionError, match=r"operator\.pem"):
        teleop(secured_cell, ca="ca.pem", certificate=str(path), key="key.pem").connect()
