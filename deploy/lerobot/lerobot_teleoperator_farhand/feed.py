"""A cell's newest state over Zenoh, and how old it is by the cell's own clock."""

import threading
import time
from typing import NamedTuple

import zenoh

from lerobot_teleoperator_farhand.session import open_session, own_key, stranger
from lerobot_teleoperator_farhand.wire import CellState, WireError, cell_state, clock_times, joint_names, question

NS_PER_S, NS_PER_MS = 10**9, 10**6
ASK_EVERY_NS = NS_PER_S
OFFSET_GOOD_NS = 5 * NS_PER_S
DRIFT = 1e-4  # two hosts' clocks drift apart by no more
QUESTION_TIMEOUT_S = 0.7
POLL_S = 0.02


class StaleDataError(RuntimeError):
    """There is no state that could be given as live; the text says why."""


class MeasuredOffset(NamedTuple):
    """The cell's steady time minus ours at `measured_ns` of ours, ns, and how wrong it may be.

    The cell's stamps are by its monotonic clock, of which steady time was `cell_ahead_ns` ahead.
    """

    offset_ns: int
    uncertainty_ns: int
    measured_ns: int
    cell_ahead_ns: int

    def bound_ns(self, now_ns: int) -> int:
        """How wrong it may be by now."""
        return self.uncertainty_ns + round(DRIFT * (now_ns - self.measured_ns))

    def is_old(self, now_ns: int) -> bool:
        """Whether a newer one should replace it, however certain it was."""
        return now_ns - self.measured_ns > OFFSET_GOOD_NS - 2 * ASK_EVERY_NS


class StateFeed:
    """A Zenoh session that hears one cell's state and asks for its clock; close it in the end."""

    def __init__(self, cell: str, remote: str, ca: str, certificate: str, key: str) -> None:
        self._cell = cell
        self._lock = threading.Lock()
        self._payload: bytes | None = None
        self._offset: MeasuredOffset | None = None
        self._asked_ns = 0
        self._describe_key = own_key(f"farhand/{cell}/rpc/describe", cell, certificate)
        self._clock_key = own_key(f"farhand/{cell}/clock", cell, certificate)
        self._session = open_session(cell, remote, ca, certificate, key)
        self._names_listener = bool(ca)
        self._subscriber = self._session.declare_subscriber(f"farhand/{cell}/state", self._take)

    def close(self) -> None:
        """Close the session."""
        self._session.close()  # type: ignore[no-untyped-call]  # zenoh leaves it unannotated

    def joint_names(self, timeout_s: float) -> list[str]:
        """The names of the cell's joints; ConnectionError where nobody answers in time, or somebody else listens."""
        until_ns = time.monotonic_ns() + round(timeout_s * NS_PER_S)
        while time.monotonic_ns() < until_ns:
            for reply in self._session.get(self._describe_key, payload=question(), timeout=QUESTION_TIMEOUT_S):
                if reply.ok is not None:
                    return joint_names(reply.ok.payload.to_bytes())
                said = reply.err.payload.to_bytes() if reply.err is not None else b""
                if said.startswith(b"refused: "):
                    raise ConnectionError(f"the cell {said.decode(errors='replace')}")
            if self._names_listener and (named := stranger(self._session, self._cell)) is not None:
                raise ConnectionError(
                    f"the listener there shows the certificate of {named}, not that of cell {self._cell!r}: is the "
                    "endpoint right, or does somebody impersonate the cell?"
                )
            time.sleep(POLL_S)
        raise ConnectionError(
            f"nobody answers for cell {self._cell!r}: is its remote site running, is the endpoint right, and do the "
            "certificates belong to it ('farhand doctor --link' says more)?"
        )

    def live(self, max_age_ms: float) -> CellState:
        """The newest state; StaleDataError unless it is surely younger than this by the cell's clock, and no fault."""
        now_ns = _steady_ns()
        self._ask(now_ns)
        with self._lock:
            payload, offset = self._payload, self._offset
        if payload is None:
            raise StaleDataError(f"no state of cell {self._cell!r} has come yet")
        try:
            state = cell_state(payload)
        except WireError as error:
            raise StaleDataError(str(error)) from error
        if offset is None or now_ns - offset.measured_ns > OFFSET_GOOD_NS:
            raise StaleDataError("the cell does not answer for its clock: the age of its state is unknown")
        age_ns = now_ns + offset.offset_ns - (state.t_ns + offset.cell_ahead_ns) + offset.bound_ns(now_ns)
        if age_ns > max_age_ms * NS_PER_MS:
            raise StaleDataError(
                f"the newest state is up to {age_ns / NS_PER_MS:.0f} ms old, at most {max_age_ms:g} ms are allowed: "
                "the link is interrupted or too slow, or the remote site has ended"
            )
        if state.state == "fault":
            raise StaleDataError(f"the arm is in a fault, and does not do what it is commanded: {state.reason}")
        return state

    def _ask(self, now_ns: int) -> None:
        """Ask for the cell's clock once a second, without waiting for the answer."""
        if now_ns - self._asked_ns < ASK_EVERY_NS:
            return
        self._asked_ns = now_ns

        def take(reply: zenoh.Reply) -> None:
            come_ns = _steady_ns()
            if reply.ok is not None:
                self._time(now_ns, reply.ok.payload.to_bytes(), come_ns)

        self._session.get(self._clock_key, take, payload=question(), timeout=QUESTION_TIMEOUT_S)

    def _time(self, asked_ns: int, answer: bytes, come_ns: int) -> None:
        """Keep what a round trip shows of the offset, unless an earlier one is still more certain."""
        try:
            received_ns, answered_ns, ahead_ns = clock_times(answer)
        except (WireError, ValueError):
            return  # the state is of the same release, and its refusal says so
        offset_ns = (received_ns + answered_ns - asked_ns - come_ns) // 2 + ahead_ns
        bound_ns = max(come_ns - asked_ns - (answered_ns - received_ns), 0) // 2 + 1
        found = MeasuredOffset(offset_ns, bound_ns, come_ns, ahead_ns)
        with self._lock:
            kept = self._offset
            if kept is None or kept.is_old(come_ns) or found.uncertainty_ns <= kept.bound_ns(come_ns):
                self._offset = found

    def _take(self, sample: zenoh.Sample) -> None:
        with self._lock:
            self._payload = sample.payload.to_bytes()


def _steady_ns() -> int:
    """Time that is neither slewed, as the monotonic clock is, nor stands still while this host is suspended."""
    boot_ns = time.clock_gettime_ns(time.CLOCK_BOOTTIME)
    return time.clock_gettime_ns(time.CLOCK_MONOTONIC_RAW) + boot_ns - time.monotonic_ns()
