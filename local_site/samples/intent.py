"""The operator's intent as it goes into every sample: what is not told anew is not held; pure."""

from msgspec.structs import replace

from common.link.channels import INTENT
from common.messages.hand import Intent, OperatorIntent


class IntentMerge:
    """Keeps the newest intent that a console or pedal of this host has told.

    Intent older than 200 ms is "not held". After such a silence, as at the start, holding counts only once it was seen
    let go: a console that comes back with its key still down moves nothing.
    """

    def __init__(self) -> None:
        self._last: OperatorIntent | None = None
        self._let_go = False

    def hear(self, told: OperatorIntent, now_ns: int) -> None:
        """Take what was told; an older intent than the last one, or one from the future, is none."""
        if told.sent_ns > now_ns or (self._last is not None and told.sent_ns <= self._last.sent_ns):
            return
        if self._last is not None and told.sent_ns - self._last.sent_ns > INTENT.stale_after_ns:
            self._let_go = False
        self._last = told
        self._let_go = self._let_go or not told.intent.hold

    def at(self, now_ns: int) -> Intent:
        """The intent of this instant."""
        if self._last is None:
            return Intent()
        if now_ns - self._last.sent_ns > INTENT.stale_after_ns:
            self._let_go = False
        return replace(self._last.intent, hold=self._last.intent.hold and self._let_go)
