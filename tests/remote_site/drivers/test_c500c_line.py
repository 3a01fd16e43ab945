"""The line to the A465's controller: frames, lost and changed bytes, repeats, queue, faults."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from common.clock import NS_PER_MS, FakeClock
from common.errors import DriverError
from remote_site.drivers.c500c.config import C500cConfig
from remote_site.drivers.c500c.driver import C500cDriver
from remote_site.drivers.c500c.emulation import EmulatedLine, EmulatedPort, Emulation, Terminal
from remote_site.drivers.c500c.emulator import Emulated, EmulatedController
from remote_site.drivers.c500c.playing import Player
from remote_site.drivers.c500c.port import open_port
from remote_site.drivers.c500c.protocol import (
    Activation,
    ControllerState,
    Fault,
    Flag,
    Kind,
    Parser,
    ProtocolFrame,
    Setpoint,
)
from remote_site.drivers.driver import DriverSetup, JointCommand
from remote_site.drivers.faults import FaultCode
from remote_site.kinematics.config import RobotConfig
from remote_site.kinematics.limits import JointLimits
from remote_site.kinematics.model import ArmModel

ROBOT = RobotConfig()
MODEL = ArmModel.from_urdf(ROBOT.urdf, ROBOT.tool_frame, ROBOT.tool_T_tcp)
SETUP = DriverSetup(MODEL.joint_names, JointLimits.from_model(MODEL, ROBOT), 0.004, 50 * NS_PER_MS)
ANGLES = st.floats(-math.pi, math.pi)
FRAMES = st.builds(ProtocolFrame, st.integers(0, 255), st.sampled_from(Kind), st.binary(max_size=40))


class Bench:
    """The driver and the emulated controller on one clock."""

    def __init__(self, *, loss=0.0, emulated=None, **options):
        self.clock = FakeClock(1000 * NS_PER_MS)
        self.controller = EmulatedController(ROBOT.start, emulated or Emulated())
        self.emulation = Emulation(self.controller, self.clock.now_ns(), loss=loss)
        self.driver = C500cDriver(C500cConfig(**options), EmulatedPort(self.emulation, self.clock), self.clock)
        self.seq, self.longest = 0, 0

    def run(self, ms):
        for _ in range(round(ms / 2)):
            self.clock.advance_ms(2)
            try:
                reading = self.driver.read()
            except DriverError:
                continue
            self.longest = max(self.longest, len(self.controller.player.queue))
        return reading

    def ready(self):
        self.driver.configure(SETUP)
        self.run(100)
        self.driver.activate(ROBOT.start)
        assert self.run(60).fault is None
        return self

    def send(self, q, periods=1, gripper_open=True):
        for _ in range(periods):
            self.seq += 1
            zero = np.zeros(6)
            self.driver.write(JointCommand(self.seq, self.clock.now_ns(), np.array(q), zero, zero, gripper_open))
            reading = self.run(67)
        return reading


@pytest.fixture
def bench():
    return Bench()


@given(st.lists(FRAMES, max_size=5), st.binary(max_size=20), st.integers(1, 40))
def test_frames_are_found_however_they_come(frames, noise, chunk):
    noise = noise.replace(b"\xa5", b"")
    data = noise + b"".join(frame.encoded for frame in frames)
    parser, found = Parser(), []
    for k in range(0, len(data), chunk):
        found += parser.feed(data[k : k + chunk])
    assert found == frames
    assert parser.damaged == 0


@given(FRAMES, st.data())
def test_a_damaged_frame_is_never_taken_for_another(frame, data):
    encoded = bytearray(frame.encoded)
    place = data.draw(st.integers(0, len(encoded) - 1))
    encoded[place] ^= data.draw(st.integers(1, 255))
    if data.draw(st.booleans()):
        del encoded[place]
    found = Parser().feed(bytes(encoded) + ProtocolFrame(9, Kind.POLL).encoded * 20)
    assert all(each == ProtocolFrame(9, Kind.POLL) for each in found)
    assert found


@given(st.binary(max_size=300))
def test_random_bytes_raise_nothing(data):
    Parser().feed(data)


@given(st.tuples(*[ANGLES] * 6), st.integers(0, 65535), st.booleans(), st.integers(1, 100))
def test_payloads_survive_the_line(joints, count, is_open, percent):
    setpoint = Setpoint.parse(Setpoint(count, joints, is_open, percent).payload)
    assert setpoint.joints == pytest.approx(joints, abs=1e-6)
    assert (setpoint.count, setpoint.gripper_open, setpoint.grip_percent) == (count, is_open, percent)
    activation = Activation.parse(Activation(count, joints, 67).payload)
    assert (activation.count, activation.period_ms) == (count, 67)
    state = ControllerState.parse(
        ControllerState(Flag.ACTIVE, Fault.BLOCKED, 2, count, count, count, 0.0501, joints).payload
    )
    assert (state.flags, state.fault, state.queued, state.begun) == (Flag.ACTIVE, Fault.BLOCKED, 2, count)
    assert state.opening_m == pytest.approx(0.0501, abs=1e-5)


def test_bytes_take_their_time():
    line = EmulatedLine(baud=57600)
    line.push(b"x" * 36, 0)
    assert len(line.pull(3 * NS_PER_MS)) == 17
    assert len(line.pull(7 * NS_PER_MS)) == 19


def test_the_controller_is_read_before_it_is_activated_and_not_invented(bench):
    bench.driver.configure(SETUP)
    with pytest.raises(DriverError, match="does not answer"):
        bench.driver.read()
    with pytest.raises(DriverError, match="does not answer"):
        bench.driver.activate(ROBOT.start)
    reading = bench.run(100)
    assert reading.q == pytest.approx(ROBOT.start, abs=1e-6)
    assert reading.fault.code is FaultCode.NOT_ACTIVATED
    assert reading.gripper.force_n is None
    age_ms = (bench.clock.now_ns() - reading.t_ns) / NS_PER_MS
    assert 5 < age_ms < 60


def test_state_comes_some_thirty_times_a_second(bench):
    bench.ready()
    times = set()
    for _ in range(500):
        times.add(bench.run(2).t_ns)
    assert 20 <= len(times) <= 45


def test_setpoints_are_reached_in_order_and_named(bench):
    bench.ready()
    goal = ROBOT.start + 0.02
    reading = bench.send(goal, periods=6)
    assert reading.q == pytest.approx(goal, abs=2e-6)
    assert bench.seq - 4 <= reading.obeyed_seq <= bench.seq


@pytest.mark.parametrize("loss", [0.0, 0.0005, 0.001])
def test_lost_bytes_are_made_good_and_no_setpoint_is_queued_twice(loss):
    bench = Bench(loss=loss).ready()
    for k in range(90):
        reading = bench.send(ROBOT.start + 0.004 * k)
        assert reading.fault is None, k
    bench.send(ROBOT.start + 0.004 * 89, periods=5)
    assert bench.run(100).q == pytest.approx(ROBOT.start + 0.004 * 89, abs=2e-6)
    assert bench.longest <= 2
    assert (bench.driver._exchange.repeats > 3) is (loss > 0)


def test_a_line_that_loses_too_much_halts_the_arm_before_a_setpoint_is_left_out():
    bench = Bench().ready()
    bench.emulation.there.loss = bench.emulation.back.loss = 0.02
    with pytest.raises(DriverError, match="does not keep up"):
        bench.send(ROBOT.start + 0.02, periods=90)
    assert bench.longest <= 2
    bench.run(500)
    assert not bench.controller.dq.any()


@pytest.mark.parametrize("drift", [0.99, 1.01])
def test_clocks_that_differ_lose_no_setpoint(drift):
    bench = Bench().ready()
    bench.controller.player.period = 0.067 * drift
    begun = []
    for k in range(200):
        reading = bench.send(ROBOT.start + 0.002 * k)
        assert reading.fault is None
        begun.append(bench.controller.player.begun)
    assert set(np.diff(begun[5:])) <= {0, 1, 2}
    assert len({*begun}) > 180


def test_a_cut_line_halts_the_arm_and_is_told(bench):
    bench.ready()
    for k in range(20):
        bench.send(ROBOT.start + 0.01 * k)
    assert np.abs(bench.controller.dq).max() > 0.05
    bench.emulation.there.loss = bench.emulation.back.loss = 1.0
    reading = bench.run(600)
    assert reading.fault.code is FaultCode.SILENT
    assert bench.controller.fault in (Fault.WATCHDOG, Fault.UNDERRUN)
    assert not bench.controller.dq.any()
    bench.emulation.there.loss = bench.emulation.back.loss = 0.0
    reading = bench.run(300)
    assert reading.fault.code in (FaultCode.WATCHDOG, FaultCode.LINK)  # the line is back, the arm stays
    rest = bench.controller.player.q.copy()
    bench.send(rest + 0.1, periods=5)
    assert (bench.controller.player.q == rest).all()


def test_setpoints_that_cease_in_motion_halt_the_arm(bench):
    bench.ready()
    for k in range(20):
        bench.send(ROBOT.start + 0.01 * k)
    reading = bench.run(600)
    assert reading.fault.code is FaultCode.LINK
    assert reading.fault.native == "UNDERRUN"
    assert not bench.controller.dq.any()


def test_a_halt_brakes_within_its_limits_and_stays_powered(bench):
    bench.ready()
    for k in range(20):
        bench.send(ROBOT.start + 0.05 * k)
    before, speeds = bench.controller.player.q.copy(), []
    bench.driver.stop()
    for _ in range(150):
        reading = bench.run(4)
        bench.driver.stop()
        speeds.append(bench.controller.dq[0])
    assert reading.fault.code is FaultCode.STOPPED
    assert speeds[0] > 0.6
    assert speeds[-1] == 0.0
    assert np.abs(np.diff(speeds)).max() <= 2 * 10.0 * 0.005 + 1e-9
    assert bench.controller.player.q[0] - before[0] < 0.1
    assert Flag.ARM_POWER in bench.driver._exchange.state.flags


def test_an_emergency_stop_is_mirrored_and_needs_release_and_activation(bench):
    bench.ready()
    for k in range(20):
        bench.send(ROBOT.start + 0.01 * k)
    bench.controller.emergency_stop = True
    reading = bench.run(60)
    assert reading.fault.code is FaultCode.EMERGENCY_STOP
    assert reading.fault.native == "EMERGENCY_STOP"
    assert not bench.controller.dq.any()
    with pytest.raises(DriverError, match="emergency stop"):
        bench.driver.activate(reading.q)
    bench.controller.emergency_stop = False
    reading = bench.run(200)
    assert reading.fault is not None
    bench.driver.activate(reading.q)
    assert bench.run(80).fault is None


def test_a_jammed_joint_halts_and_is_told(bench):
    bench.ready()
    for k in range(20):
        bench.send(ROBOT.start + 0.01 * k)
    bench.controller.jammed = True
    assert bench.run(200).fault.code is FaultCode.BLOCKED


def test_activation_elsewhere_is_refused_by_the_controller(bench):
    bench.driver.configure(SETUP)
    bench.run(100)
    bench.driver.activate(ROBOT.start + 0.1)
    assert bench.run(80).fault.code is FaultCode.APART


def test_the_gripper_closes_on_the_object_at_its_percentage():
    bench = Bench(emulated=Emulated(object_m=0.03), grip_percent=90, hold_percent=60, strong_grip_s=0.3).ready()
    reading = bench.send(ROBOT.start, periods=3, gripper_open=False)
    assert bench.controller.gripper.percent == 90
    reading = bench.send(ROBOT.start, periods=12, gripper_open=False)
    assert reading.gripper.opening_m == pytest.approx(0.03, abs=1e-4)
    assert bench.controller.gripper.percent == 60
    reading = bench.send(ROBOT.start, periods=12)
    assert reading.gripper.opening_m == pytest.approx(0.0508, abs=1e-4)


@given(st.lists(st.floats(-0.2, 0.2), min_size=3, max_size=15))
def test_the_way_between_setpoints_turns_nowhere_else(steps):
    player, places = Player(np.zeros(1), 0.1), np.cumsum([0.0, *steps])
    waiting, seen = list(enumerate(places[1:], start=1)), []
    for _ in range(len(steps) * 20 + 60):
        while waiting and player.add(waiting[0][0], np.array([waiting[0][1]])):
            waiting.pop(0)
        if not waiting and len(player.queue) < 2:
            player.add(99, np.array([places[-1]]))
        assert player.tick(0.005)
        seen.append(player.q[0])
    assert max(seen) <= places.max() + 1e-9
    assert min(seen) >= places.min() - 1e-9
    assert seen[-1] == pytest.approx(places[-1])


def test_a_terminal_carries_bytes_as_they_are():
    terminal = Terminal.create()
    port, far = open_port(terminal.path, 57600), terminal.port
    port.write(bytes(range(256)))
    assert far.read() == bytes(range(256))
    far.write(b"\r\n\x03\x04\xa5")
    assert port.read() == b"\r\n\x03\x04\xa5"
    assert port.read() == b""
