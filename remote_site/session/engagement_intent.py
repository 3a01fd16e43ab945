"""The operator's intent that the arm follows: automatic engagement, requests, a key or pedal held down; pure."""

from common.clock import NS_PER_S
from remote_site.reasons import Code, Reason, reason
from remote_site.session.config import EngagementMode

AUTOMATIC_NS = 60 * NS_PER_S  # how long automatic engagement waits for the hand once both sites are ready
AUTOMATIC_WAIT_NS = 600 * NS_PER_S  # how long it waits for both sites
INPUTS = {EngagementMode.HOLD_TO_RUN: "key", EngagementMode.PEDAL: "pedal"}


class HoldToRun:
    """The input that the operator holds down; after `end` only a new press counts: nothing starts again by itself."""

    def __init__(self) -> None:
        self.held = False
        self.armed = False

    def see(self, held: bool | None) -> bool:
        """Take the input's state from a sample, None where nobody reports it; True when it has just been released."""
        released = self.held and not held
        self.armed = held is not None and (self.armed or not held)
        self.held = self.armed and bool(held)
        return released

    def end(self) -> None:
        """The engagement, the lease or the sight of the operator has ended."""
        self.held = self.armed = False


class EngagementIntent:
    """The sources of an engagement: `armed` for the automatic one, `requested`, or the `input` held down."""

    def __init__(self, mode: EngagementMode) -> None:
        self.armed = mode is EngagementMode.AUTOMATIC
        self._armed_until_ns: int | None = None
        self._both_ready = False
        self.requested = False
        self.input = INPUTS.get(mode)
        self.hold = HoldToRun()

    def expires(self, now_ns: int, *, both_ready: bool) -> bool:
        """Disarm the automatic engagement when its time is up; True when that happens now.

        Its time ends 60 s after robot and local site were first ready together, and in any case 11 minutes after the
        first call: who shows a hand later did not ask for a motion.
        """
        if self._armed_until_ns is None:
            self._armed_until_ns = now_ns + AUTOMATIC_WAIT_NS + AUTOMATIC_NS
        if both_ready and not self._both_ready:
            self._both_ready = True
            self._armed_until_ns = min(self._armed_until_ns, now_ns + AUTOMATIC_NS)
        expired = self.armed and now_ns >= self._armed_until_ns
        self.armed = self.armed and not expired
        return expired

    def released(self, held: bool | None) -> bool:
        """Take the input's state as in `HoldToRun.see`; True when an input that counts has just been released."""
        return self.hold.see(held) and self.input is not None

    def end(self) -> None:
        """Withdraw everything: only a request, or a new press, engages again."""
        self.armed = self.requested = False
        self.hold.end()

    def lacking(self) -> Reason | None:
        """Say why the input does not engage; None where none is needed or it is held."""
        if self.input is None or self.hold.held:
            return None
        return reason(Code.NOT_HELD if self.hold.armed else Code.LET_GO_FIRST, input=self.input)
