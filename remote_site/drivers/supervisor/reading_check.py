"""Check that a driver's reading can be true: types, numbers, ranges, motion, and a stamp that advances; pure."""

import math
from typing import TypeGuard

import numpy as np

from common.clock import NS_PER_MS, NS_PER_S
from common.geometry import Array
from remote_site.drivers.driver import Capabilities, DriverSetup, GripperReading, RobotReading
from remote_site.drivers.faults import FaultCode, RobotFault
from remote_site.safety.silence import Silence

NOISE_RAD = 0.05  # of a reading; as much as 13 ms that a stamp is off, at full speed
FASTER = 1.25  # times a joint's own speed, by its positions: it overshoots, and a slow robot's clock is another
OLDEST_NS = 100 * NS_PER_MS
OLDEST_PERIODS = 4  # of a slow robot: an answer lost twice on a noisy line is no silence yet
PAUSE_NS = 50 * NS_PER_MS
# An arm may lean on its mechanical stop, some degrees beyond its range, and its zero may be off by as much.
BEYOND_RAD = 0.2
FASTEST = 10.0  # times it, as a speed is read: positions differenced by uneven stamps give several times too much
OPENING_M = (-0.01, 1.0)  # a zero may be off by some mm; no gripper that can be configured opens half as wide
FORCE_N = 2000.0  # ten times the largest grip force that can be configured
CHECK = "check the robot's sensors and the driver"

Field = tuple[str, object, str, bool]  # of a reading: its name, its value, what it has to be, and whether it is


class PlausibleMotion:
    """Bounds the positions of joints with these own speeds (n,) rad/s, of a robot with this period.

    Every reading before counts, not the last alone: what drifts faster than a joint moves is no motion either. The
    bounds widen with time, so that a posture which stays is plausible once the joints had the time to get there.
    `unseen_ns` is how long nobody looked before a reading: its stamp may be off by as much.
    """

    def __init__(self, velocity: Array, period_s: float) -> None:
        self._fastest = FASTER * velocity
        self._noise = NOISE_RAD + self._fastest * period_s  # a slow robot's reading may be repeated under a new stamp
        self.restart()

    def restart(self) -> None:
        """Forget every reading: the next one may be anywhere."""
        self._least = np.full(len(self._fastest), -np.inf)
        self._most = np.full(len(self._fastest), np.inf)
        self._noted_ns = 0

    def bounds(self, t_ns: int, unseen_ns: int) -> tuple[Array, Array]:
        """The least and the largest plausible positions (n,) in rad at a time; infinite before the first reading."""
        way = self._fastest * ((max(t_ns - self._noted_ns, 0) + unseen_ns) / NS_PER_S)
        return self._least - way, self._most + way

    def note(self, q: Array, t_ns: int, unseen_ns: int) -> None:
        """Take a plausible reading `q` (n,) in rad, measured at `t_ns`."""
        least, most = self.bounds(t_ns, 0)
        off = self._noise + self._fastest * (unseen_ns / NS_PER_S)
        self._least, self._most = np.maximum(least, q - off), np.minimum(most, q + off)
        self._noted_ns = t_ns


class ReadingCheck:
    """Judges every reading before anything else uses it.

    `oldest_ns` is how old a reading may become by its own stamp: an unchanged stamp is no new reading. A pause of this
    process itself does not count. What is refused is not remembered: the next reading is judged by the ones before it.
    """

    def __init__(self, capabilities: Capabilities, setup: DriverSetup) -> None:
        own = setup.joint_range
        lower, upper, fastest = own.lower - BEYOND_RAD, own.upper + BEYOND_RAD, FASTEST * own.velocity
        self.oldest_ns = max(OLDEST_NS, round(OLDEST_PERIODS * NS_PER_S / capabilities.rate_hz))
        self._names = setup.joint_names
        self._positions = list(zip(lower.tolist(), upper.tolist(), strict=True))
        self._speeds = [(-speed, speed) for speed in fastest.tolist()]
        self._motion = PlausibleMotion(own.velocity, 1.0 / capabilities.rate_hz)
        self._silence = Silence(PAUSE_NS)
        self._newest_ns = 0
        self._judged_ns: int | None = None

    def restart(self) -> None:
        """The robot is activated: where it is read then is compared with where it was activated, not with before."""
        self._motion.restart()

    def judge(self, reading: object, now_ns: int) -> RobotReading | RobotFault:
        """The reading with arrays of its own, or the fault: of the robot where it reports one, else of the reading.

        DRIVER is the fault of a wrong type or shape, NOT_FINITE and IMPLAUSIBLE of numbers, SILENT of an old stamp.
        """
        wrong = _malformed(reading, len(self._names))
        if not isinstance(reading, RobotReading) or wrong:
            return RobotFault(FaultCode.DRIVER, f"the driver's read returned {wrong}; correct the driver")
        t_ns = int(reading.t_ns)
        unseen_ns = now_ns - (self._judged_ns or now_ns)
        self._judged_ns = now_ns
        mistimed = self._mistimed(t_ns, now_ns)  # in every turn, whatever else is wrong
        fault = self._impossible(reading) or mistimed or self._jumped(reading.q, t_ns, unseen_ns)
        if fault is not None:
            return reading.fault if reading.fault is not None and not reading.fault.calm else fault
        self._newest_ns = t_ns
        self._motion.note(reading.q, t_ns, unseen_ns)
        grip = reading.gripper
        if grip is not None:
            grip = GripperReading(float(grip.opening_m), None if grip.force_n is None else float(grip.force_n))
        # a driver may go on writing to arrays that it has handed over
        q, dq = np.array(reading.q, dtype=float), np.array(reading.dq, dtype=float)
        return RobotReading(t_ns, q, dq, grip, reading.fault, reading.obeyed_seq)

    def _impossible(self, reading: RobotReading) -> RobotFault | None:
        for what, unit, values, ranges in (
            ("is", "rad", reading.q, self._positions),
            ("moves at", "rad/s", reading.dq, self._speeds),
        ):
            for name, value, allowed in zip(self._names, values.tolist(), ranges, strict=True):
                if not allowed[0] <= value <= allowed[1]:
                    return _fault(f"{name} {what}", value, allowed, unit)
        grip = reading.gripper
        if grip is not None and not OPENING_M[0] <= grip.opening_m <= OPENING_M[1]:
            return _fault("the gripper's opening is", grip.opening_m, OPENING_M, "m")
        if grip is not None and grip.force_n is not None and not -FORCE_N <= grip.force_n <= FORCE_N:
            return _fault("the grip force is", grip.force_n, (-FORCE_N, FORCE_N), "N")
        return None

    def _jumped(self, q: Array, t_ns: int, unseen_ns: int) -> RobotFault | None:
        """The fault of a joint that is farther from its readings before than it can have moved since."""
        least, most = self._motion.bounds(t_ns, unseen_ns)
        beyond = np.maximum(least - q, q - most)
        k = int(beyond.argmax())
        if beyond[k] <= 0.0:
            return None
        jumped = f"{self._names[k]} jumped to {_short(float(q[k]))} rad in {_ms(t_ns - self._newest_ns)}"
        possible = f"only {float(least[k]):.4g} to {float(most[k]):.4g} can be true"
        return RobotFault(FaultCode.IMPLAUSIBLE, f"the reading of {jumped}, where {possible}; {CHECK}")

    def _mistimed(self, t_ns: int, now_ns: int) -> RobotFault | None:
        age_ns = self._silence.of(min(max(t_ns, 0), now_ns), now_ns)
        if t_ns > now_ns:
            return _bad_stamp(f"{_ms(t_ns - now_ns)} in the future")
        if t_ns <= 0 or t_ns < self._newest_ns:
            return _bad_stamp("not set" if t_ns <= 0 else f"{_ms(self._newest_ns - t_ns)} before the last one's")
        return stale(age_ns, self.oldest_ns) if age_ns > self.oldest_ns else None


def stale(age_ns: int, oldest_ns: int) -> RobotFault:
    """The fault of a reading that has become too old."""
    limit = f"limit {oldest_ns / NS_PER_MS:.0f} ms"
    return RobotFault(
        FaultCode.SILENT, f"the robot was last measured {_ms(age_ns)} ago ({limit}); check the link to it"
    )


def _fault(what: str, value: float, allowed: tuple[float, float], unit: str) -> RobotFault:
    if isinstance(value, float | np.floating) and not math.isfinite(value):
        return RobotFault(FaultCode.NOT_FINITE, f"by its reading {what} not finite; {CHECK}")
    bounds = f"{allowed[0]:.4g} to {allowed[1]:.4g} {unit}"
    return RobotFault(FaultCode.IMPLAUSIBLE, f"by its reading {what} {_short(value)}, outside {bounds}; {CHECK}")


def _bad_stamp(what: str) -> RobotFault:
    return RobotFault(FaultCode.IMPLAUSIBLE, f"the time of the reading is {what}; correct the driver's clock")


def _ms(ns: int) -> str:
    return f"{_short(ns / NS_PER_MS)} ms" if abs(ns) < NS_PER_S * NS_PER_S else "years"


def _short(value: float) -> str:
    return f"{value:.4g}" if abs(value) < 1e100 else "huge"  # an int may have any number of digits


def _malformed(reading: object, joints: int) -> str:
    """Say what a driver returned instead of a reading, or in a field of it; "" where every type and shape is right."""
    if not isinstance(reading, RobotReading):
        return f"{_type(reading)}, not a RobotReading"
    wrong = (*_own_fields(reading, joints), *_gripper_fields(reading.gripper), *_fault_fields(reading.fault))
    return next((f"{_type(value)} as {name}, not {wanted}" for name, value, wanted, good in wrong if not good), "")


def _own_fields(reading: RobotReading, joints: int) -> tuple[Field, ...]:
    grip, fault, obeyed = reading.gripper, reading.fault, reading.obeyed_seq
    return (
        ("t_ns", reading.t_ns, "an int", _whole(reading.t_ns)),
        ("q", reading.q, f"an array of {joints} numbers", _joints(reading.q, joints)),
        ("dq", reading.dq, f"an array of {joints} numbers", _joints(reading.dq, joints)),
        ("gripper", grip, "a GripperReading, or None", grip is None or isinstance(grip, GripperReading)),
        ("fault", fault, "a RobotFault, or None", fault is None or isinstance(fault, RobotFault)),
        ("obeyed_seq", obeyed, "an int, or None", obeyed is None or _whole(obeyed)),
    )


def _gripper_fields(grip: GripperReading | None) -> tuple[Field, ...]:
    if not isinstance(grip, GripperReading):
        return ()
    return (
        ("gripper.opening_m", grip.opening_m, "a number", _number(grip.opening_m)),
        ("gripper.force_n", grip.force_n, "a number, or None", grip.force_n is None or _number(grip.force_n)),
    )


def _fault_fields(fault: RobotFault | None) -> tuple[Field, ...]:
    if not isinstance(fault, RobotFault):
        return ()
    return (
        ("fault.code", fault.code, "a FaultCode", isinstance(fault.code, FaultCode)),
        ("fault.sentence", fault.sentence, "a str", isinstance(fault.sentence, str)),
        ("fault.native", fault.native, "a str", isinstance(fault.native, str)),
    )


def _whole(value: object) -> bool:
    return isinstance(value, int | np.integer) and not isinstance(value, bool)


def _number(value: object) -> bool:
    return _whole(value) or isinstance(value, float | np.floating)


def _joints(value: object, joints: int) -> TypeGuard[Array]:
    return isinstance(value, np.ndarray) and value.shape == (joints,) and value.dtype.kind in "fiu"


def _type(value: object) -> str:
    shape = f" of shape {value.shape} and dtype {value.dtype}" if isinstance(value, np.ndarray) else ""
    return f"{type(value).__name__}{shape}"
