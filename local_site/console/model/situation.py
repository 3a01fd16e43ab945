"""The situation as the console knows it, sent to pages as JSON about 17 times a second."""

from dataclasses import asdict, dataclass
from typing import Any

import msgspec

from common.clock import NS_PER_MS, ClockEstimate
from common.link.channels import HAND, RECORDING, STATE
from common.messages.hand import HandArm, OperatorSettings
from common.messages.recording import RecordingNotice
from common.messages.robot import LeaseState, RobotState
from local_site.console.model.history import History
from local_site.console.model.latency import Latencies
from local_site.console.model.seat import Seat, Visitor

NOT_FOR_PAGES = ("session", "clock", "obeyed", "traced", "settings", "reference")
MILD_MS = 200.0  # up to here a delay's effect on manipulation is mild (Xu et al., Surg Endosc 28, 2014)
STEP = 0.05  # of the page's control
LEAST = 0.1


def loop_delay_ms(picture_ms: float | None, round_trip_ms: float | None) -> float | None:
    """Compute the delay between hand and eye, ms: the way there, and the picture's age when it is painted.

    The age contains the way back; the way there is half the round trip. None while one of them is not known.
    """
    return None if picture_ms is None or round_trip_ms is None else picture_ms + 0.5 * round_trip_ms


def suggested_scale(loop_ms: float | None) -> float:
    """The operator's scale at which the tool goes no further unseen than at full scale after the longest mild delay.

    During the delay the tool goes scale * speed of the hand * delay before the operator sees any of it (Ferrell 1965):
    the scale falls as the delay's inverse. In steps of the page's control; 1 while the delay is mild or not known.
    """
    if loop_ms is None or loop_ms <= MILD_MS:
        return 1.0
    return round(max(LEAST, STEP * round(MILD_MS / loop_ms / STEP)), 2)


@dataclass(frozen=True, slots=True)
class NewestMessages:
    """The newest messages of both sites and when they came (ns), None and 0 before the first."""

    state: RobotState | None = None
    state_ns: int = 0
    hand: HandArm | None = None
    hand_ns: int = 0
    notice: RecordingNotice | None = None
    notice_ns: int = 0


def situation_json(
    now_ns: int,
    newest: NewestMessages,
    clock: ClockEstimate | None,
    round_trip_ms: float | None,
    seat: Seat,
    settings: OperatorSettings | None,
    latencies: Latencies,
    history: History,
) -> str:
    """Everything a page shows besides pictures; `clock` is the current estimate of the remote one, if there is one.

    `settings` are the operator's, with the operating page's changes; None while those in force are unknown.
    """
    latency = latencies.summary(now_ns)
    situation = {
        "type": "situation",
        "now_ms": now_ns / NS_PER_MS,
        "robot": _robot_fields(newest, newest.state, now_ns) if newest.state is not None else None,
        "hand": _hand_fields(newest.hand, newest.hand_ns, now_ns) if newest.hand is not None else None,
        "own_recording": _own_recording(newest, now_ns),
        "clock": _clock_fields(clock, round_trip_ms),
        "delay": _delay_fields(latency),
        "seat": _page_fields(seat.occupant)
        | {
            "held": seat.held(now_ns),
            "late": seat.late(now_ns),
        },
        "settings": msgspec.to_builtins(settings),
        "latency": latency,
        "trace": asdict(latencies.trace) if latencies.trace is not None else None,
        "unanswered": history.unanswered.reason,
        "stopper": _page_fields(history.stopper.page),
        "events": [
            {"number": e.number, "ago_ms": (now_ns - e.t_ns) / NS_PER_MS, "kind": e.kind, "text": e.text}
            for e in history.events
        ],
    }
    return msgspec.json.encode(situation).decode()


def _page_fields(page: Visitor | None) -> dict[str, Any]:
    """A page's number, and what people call it; both None without one."""
    return {"page": page.number, "who": str(page)} if page is not None else {"page": None, "who": None}


def _robot_fields(newest: NewestMessages, state: RobotState, now_ns: int) -> dict[str, Any]:
    """The robot's state, with its age since it was received."""
    fields: dict[str, Any] = msgspec.to_builtins(state)
    for name in NOT_FOR_PAGES:
        del fields[name]
    if state.lease is not None:
        fields["lease"] |= _lease_fields(state.lease, newest.hand)
    return fields | {
        "heard_ms": (now_ns - newest.state_ns) / NS_PER_MS,
        "silent": now_ns - newest.state_ns > STATE.stale_after_ns,
        "halted_ns": str(state.halted_ns),  # JavaScript would round it
        "lease_left_ms": (state.lease.expires_ns - state.t_ns) / NS_PER_MS if state.lease is not None else None,
    }


def _lease_fields(lease: LeaseState, hand: HandArm | None) -> dict[str, Any]:
    """Whose the lease is, in words, and whether it is that of the local site here; who asks for it."""
    asker = lease.asked_by
    return {
        "words": str(lease),
        "ours": hand is not None and hand.session == lease.session,
        "local_known": hand is not None,
        "asked_by": None  # its session in decimal, since JavaScript would round it
        if asker is None
        else {"name": asker.name, "session": str(asker.session), "words": str(asker)},
    }


def _hand_fields(hand: HandArm, received_ns: int, now_ns: int) -> dict[str, Any]:
    return {
        "status": hand.status.value,
        "reason": hand.reason,
        "open": hand.hand_open,
        "toggles": hand.gripper_toggles,
        "thumb_inferred": hand.thumb_inferred,
        "age_ms": (now_ns - hand.capture_ns) / NS_PER_MS,
        "silent": now_ns - received_ns > 5 * HAND.stale_after_ns,
    }


def _own_recording(newest: NewestMessages, now_ns: int) -> dict[str, Any] | None:
    """Return what the recorder of the operator's own side does; None where none has reported lately."""
    if newest.notice is None or now_ns - newest.notice_ns > RECORDING.stale_after_ns:
        return None
    fields: dict[str, Any] = msgspec.to_builtins(newest.notice.state)
    return fields


def _delay_fields(latency: dict[str, dict[str, float | int | None]]) -> dict[str, float | None]:
    """The medians of the last minute count: a suggestion that changes with every picture would be none."""
    loop_ms = loop_delay_ms(latency["picture"]["p50"], latency["round_trip"]["p50"])
    return {"loop_ms": loop_ms, "suggested_scale": suggested_scale(loop_ms)}


def _clock_fields(clock: ClockEstimate | None, round_trip_ms: float | None) -> dict[str, float | None]:
    offset = clock.offset if clock is not None else None
    return {
        "offset_ms": offset.offset_ns / NS_PER_MS if offset is not None else None,
        "uncertainty_ms": offset.uncertainty_ns / NS_PER_MS if offset is not None else None,
        "round_trip_ms": round_trip_ms,
    }
