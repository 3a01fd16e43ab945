"""Whether the operator wants the arm to follow: automatic engagement, requests, a key or pedal held down; pure."""

from remote_site.reasons import Code, Reason, reason
from remote_site.session.config import EngagementMode

INPUTS = {EngagementMode.HOLD_TO_RUN: "key", EngagementMode.PEDAL: "pedal"}


class HoldToRun:
    """What the operator holds down; after `end` only a new press counts: what has ended does not start by itself."""

    def __init__(self) -> None:
        self.held = False
        self.armed = False

    def see(self, held: bool) -> bool:
        """Take the input's state from a sample; True when it has just been released."""
        released = self.held and not held
        self.armed = self.armed or not held
        self.held = held and self.armed
        return released

    def end(self) -> None:
        """The engagement, the lease or the sight of the operator has ended."""
        self.held = self.armed = False


class EngagementIntent:
    """What asks for an engagement: `armed` for the automatic one, `requested`, or the `input` held down."""

    def __init__(self, mode: EngagementMode) -> None:
        self.armed = mode is EngagementMode.AUTOMATIC
        self.requested = False
        self.input = INPUTS.get(mode)
        self.hold = HoldToRun()

    def released(self, held: bool) -> bool:
        """Take the input's state from a sample; True when an input that counts has just been released."""
        return self.hold.see(held) and self.input is not None

    def end(self) -> None:
        """Withdraw everything: only a request, or a new press, engages again."""
        self.armed = self.requested = False
        self.hold.end()

    def lacking(self) -> Reason | None:
        """Why the input does not engage, None where none is needed or it is held."""
        if self.input is None or self.hold.held:
            return None
        return reason(Code.NOT_HELD if self.hold.armed else Code.LET_GO_FIRST, input=self.input)
