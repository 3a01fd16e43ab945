"""Plays scenarios of the conformance vectors against the emulated controller on simulated time, comparing answers."""

import struct
from collections.abc import Iterator

import numpy as np

from common.clock import NS_PER_MS
from remote_site.drivers.c500c.emulation import Emulation
from remote_site.drivers.c500c.emulator import EmulatedController
from remote_site.drivers.c500c.protocol import RAD
from tests.remote_site.drivers.c500c.vectors import ByHand, Scenario, Start, Step

ANSWER_MS = 25
FLAGS = {"active": 1, "moving": 2, "arm power": 4, "emergency stop": 8, "gripper busy": 16}
STATE = struct.Struct("<BBBHHHH6i")  # flags, fault, queued, activation, begun, taken, opening, joints


def mistakes(start: Start, scenario: Scenario) -> Iterator[str]:
    """Play the scenario; what is wrong with its answers, in words."""
    controller = EmulatedController(np.array(start.joints_urad) * RAD)
    emulation = Emulation(controller, 0)
    ends_ms = [step.at_ms for step in scenario.step[1:]] + [scenario.step[-1].at_ms + ANSWER_MS]
    for step, end_ms in zip(scenario.step, ends_ms, strict=True):
        emulation.exchange(b"", step.at_ms * NS_PER_MS)  # what has come until now answers the step before
        if step.do is not None:
            _by_hand(controller, step.do)
        answer, took_ms = _send(emulation, step, end_ms)
        for mistake in _wrong(start, step, answer, took_ms):
            yield f"at {step.at_ms} ms, {step.says} {mistake}: {answer.hex(' ')}"


def _send(emulation: Emulation, step: Step, end_ms: int) -> tuple[bytes, int]:
    """All bytes that come back before the next step, and ms until the last of them."""
    answer, took_ms = emulation.exchange(bytes.fromhex(step.send), step.at_ms * NS_PER_MS), 0
    for now_ms in range(step.at_ms + 1, end_ms + 1):
        if came := emulation.exchange(b"", now_ms * NS_PER_MS):
            answer, took_ms = answer + came, now_ms - step.at_ms
    return answer, took_ms


def _by_hand(controller: EmulatedController, what: ByHand) -> None:
    match what:
        case "press emergency stop" | "release emergency stop":
            controller.emergency_stop = what == "press emergency stop"
        case "switch arm power off" | "switch arm power on":
            controller.arm_power = what == "switch arm power on"


def _wrong(start: Start, step: Step, answer: bytes, took_ms: int) -> Iterator[str]:
    if step.expect is None:
        return
    if not _matches(step.expect, answer):
        yield f"answered, not {step.expect!r}"
    elif answer:
        if took_ms > ANSWER_MS:
            yield f"answered after {took_ms} ms"
        yield from _wrong_state(start, step, STATE.unpack(answer[4:-2][: STATE.size]))


def _wrong_state(start: Start, step: Step, state: tuple[int, ...]) -> Iterator[str]:
    flags, _, _, _, begun, taken, opening, *joints = state
    yield from (f"{name} is not set" for name in step.flags_set if not flags & FLAGS[name])
    yield from (f"{name} is set" for name in step.flags_clear if flags & FLAGS[name])
    if step.joints_urad and np.abs(np.subtract(step.joints_urad, joints)).max() > start.tolerance_urad:
        yield f"the joints are {joints}"
    if step.opening_10um and not step.opening_10um[0] <= opening <= step.opening_10um[1]:
        yield f"the gripper is {opening} open"
    if begun == step.begun_is_not:
        yield f"{begun} has begun"
    if taken == step.taken_is_not:
        yield f"{taken} is taken"


def _matches(pattern: str, answer: bytes) -> bool:
    wanted = pattern.split()
    return len(wanted) == len(answer) and all(
        want in ("??", f"{byte:02X}") for want, byte in zip(wanted, answer, strict=True)
    )
