"""The situation as the console knows it, told to pages as JSON about 17 times a second; pure."""

from dataclasses import asdict, dataclass
from typing import Any

import msgspec

from common.clock import NS_PER_MS, ClockEstimate
from common.link.channels import HAND, STATE
from common.messages.hand import HandArm, Intent
from common.messages.robot import RobotState
from local_site.console.history import History
from local_site.console.latency import Latencies
from local_site.console.seat import Seat


@dataclass(frozen=True, slots=True)
class Heard:
    """The newest messages of both sites and when they came (ns), None and 0 before the first."""

    state: RobotState | None = None
    state_ns: int = 0
    hand: HandArm | None = None
    hand_ns: int = 0


@dataclass(frozen=True, slots=True)
class Clocks:
    """The remote clock as known now, and how long its last question took, ms."""

    estimate: ClockEstimate | None
    round_trip_ms: float | None


def robot_fields(heard: Heard, now_ns: int) -> dict[str, Any] | None:
    """The robot's state for the page, with how long ago it was heard; None before the first."""
    state = heard.state
    if state is None:
        return None
    fields: dict[str, Any] = msgspec.to_builtins(state)
    for large in ("version", "session", "clock", "obeyed", "traced"):
        del fields[large]
    silent_ms = (now_ns - heard.state_ns) / NS_PER_MS
    return fields | {
        "heard_ms": silent_ms,
        "silent": now_ns - heard.state_ns > STATE.stale_after_ns,
        "lease_left_ms": (state.lease.expires_ns - state.t_ns) / NS_PER_MS if state.lease is not None else None,
    }


def hand_fields(heard: Heard, now_ns: int) -> dict[str, Any] | None:
    """The tracked hand for the page; None before the first."""
    hand = heard.hand
    if hand is None:
        return None
    return {
        "status": hand.status.value,
        "reason": hand.reason,
        "open": hand.hand_open,
        "toggles": hand.gripper_toggles,
        "thumb_inferred": hand.thumb_inferred,
        "age_ms": (now_ns - hand.capture_ns) / NS_PER_MS,
        "silent": now_ns - heard.hand_ns > 5 * HAND.stale_after_ns,
    }


def tell(
    now_ns: int,
    heard: Heard,
    clocks: Clocks,
    seat: Seat,
    intent: Intent,
    latencies: Latencies,
    history: History,
) -> bytes:
    """Everything a page shows besides pictures."""
    known = clocks.estimate
    told = {
        "type": "situation",
        "now_ms": now_ns / NS_PER_MS,
        "robot": robot_fields(heard, now_ns),
        "hand": hand_fields(heard, now_ns),
        "clock": {
            "offset_ms": known.offset.offset_ns / NS_PER_MS if known is not None else None,
            "uncertainty_ms": known.offset.uncertainty_ns / NS_PER_MS if known is not None else None,
            "round_trip_ms": clocks.round_trip_ms,
        },
        "seat": {
            "page": seat.occupant.number if seat.occupant is not None else None,
            "who": str(seat.occupant) if seat.occupant is not None else None,
            "held": seat.held(now_ns),
        },
        "intent": msgspec.to_builtins(intent),
        "latency": latencies.summary(now_ns),
        "trace": asdict(latencies.trace) if latencies.trace is not None else None,
        "events": [
            {"number": e.number, "ago_ms": (now_ns - e.t_ns) / NS_PER_MS, "kind": e.kind, "text": e.text}
            for e in history.events
        ],
    }
    return msgspec.json.encode(told)
