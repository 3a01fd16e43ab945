"""Readings that must not be used, by what is wrong with them, and the code of the fault that each is to become."""

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from common.clock import NS_PER_MS, NS_PER_S
from remote_site.drivers.driver import GripperReading, RobotReading
from remote_site.drivers.faults import FaultCode
from tests.remote_site.driven_loop import Spoil


def joint(value: float, field: str = "q") -> Spoil:
    """The third joint's position or speed is this."""

    def spoil(reading: RobotReading) -> RobotReading:
        values = getattr(reading, field).copy()
        values[2] = value
        return replace(reading, **{field: values})

    return spoil


def gripper(opening_m: object, force_n: object = 1.0) -> Spoil:
    """The gripper's opening and force are these."""
    return lambda reading: replace(reading, gripper=GripperReading(opening_m, force_n))  # type: ignore[arg-type]


def field(name: str, value: object) -> Spoil:
    """One field of the reading is this."""
    return lambda reading: replace(reading, **{name: value})  # type: ignore[arg-type]


def later(ms: float) -> Spoil:
    """The stamp is off by this."""
    return lambda reading: replace(reading, t_ns=reading.t_ns + round(ms * NS_PER_MS))


def drifting(rad: float, k: int = 0, rad_s: float = 1.5) -> Callable[[RobotReading], RobotReading]:
    """Joint `k` is read off by more and more, no faster than a joint moves, up to this."""
    begun_ns: list[int] = []

    def spoil(reading: RobotReading) -> RobotReading:
        begun_ns.append(reading.t_ns)
        q = reading.q.copy()
        q[k] += math.copysign(min(rad_s * (reading.t_ns - begun_ns[0]) / NS_PER_S, abs(rad)), rad)
        return replace(reading, q=q)

    return spoil


NAN, INF = float("nan"), float("inf")
F = FaultCode
SPOILED: dict[str, tuple[Spoil, FaultCode]] = {
    "a joint is NaN": (joint(NAN), F.NOT_FINITE),
    "a joint is infinite": (joint(-INF), F.NOT_FINITE),
    "a speed is NaN": (joint(NAN, "dq"), F.NOT_FINITE),
    "the opening is NaN": (gripper(NAN), F.NOT_FINITE),
    "the force is NaN": (gripper(0.05, NAN), F.NOT_FINITE),
    "a joint is far outside its range": (joint(7.0), F.IMPLAUSIBLE),
    "a joint has jumped within its range": (joint(0.3), F.IMPLAUSIBLE),
    "a speed is that of no arm": (joint(-400.0, "dq"), F.IMPLAUSIBLE),
    "the opening is that of no gripper": (gripper(50.8), F.IMPLAUSIBLE),
    "the opening is far below zero": (gripper(-0.5), F.IMPLAUSIBLE),
    "the force is that of no gripper": (gripper(0.05, 1e9), F.IMPLAUSIBLE),
    "the stamp is of the future": (later(1.0), F.IMPLAUSIBLE),
    "the stamp goes back": (later(-30.0), F.IMPLAUSIBLE),
    "the stamp is zero": (field("t_ns", 0), F.IMPLAUSIBLE),
    "the stamp is a float": (field("t_ns", 1.5e9), F.DRIVER),
    "the stamp is NaN": (field("t_ns", NAN), F.DRIVER),
    "the stamp is a string": (field("t_ns", "now"), F.DRIVER),
    "the joints are a list": (field("q", [0.0] * 6), F.DRIVER),
    "the joints are five": (field("q", np.zeros(5)), F.DRIVER),
    "the joints are strings": (field("q", np.array(["0"] * 6)), F.DRIVER),
    "the speeds are None": (field("dq", None), F.DRIVER),
    "the gripper is a number": (field("gripper", 0.05), F.DRIVER),
    "the opening is a string": (gripper("open"), F.DRIVER),
    "the force is a string": (gripper(0.05, "strong"), F.DRIVER),
    "the fault is a string": (field("fault", "E42"), F.DRIVER),
    "the obeyed command is a list": (field("obeyed_seq", [1]), F.DRIVER),
    "there is no reading": (lambda _: None, F.DRIVER),
}
