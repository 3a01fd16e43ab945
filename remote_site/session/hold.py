"""A hold within an engagement: how long it may last, what earns its end, and whether the origins outlast it; pure."""

from common.clock import NS_PER_MS, NS_PER_S
from remote_site.reasons import Code, Reason, reason
from remote_site.safety.config import SafetyConfig

SHORT_NS = 300 * NS_PER_MS
APART_NS = 5 * NS_PER_S  # a hold that begins sooner after another lasts longer
LEAST_NS = NS_PER_S  # then: so the state changes at most twice a second
BEFORE_NS = NS_PER_S // 2  # a stop of the driver this long before a hold belongs to it
OF_AGE = (Code.STALE, Code.DUPLICATE, Code.OLD)  # of samples that only came too late
OF_CLUTCH = (Code.CLUTCHED, Code.CLUTCH_UNSEEN, Code.CLUTCH_SETTLING)


class Hold:
    """The present or last hold of an engagement, since `began_ns`; `clutched` if the operator held the clutch in it."""

    def __init__(self, config: SafetyConfig) -> None:
        self._longest_ns = round(config.longest_hold_ms * NS_PER_MS)
        self.began_ns = self._troubled_ns = -APART_NS
        self._repeated = self._of_age = self.clutched = False
        self._diverted_ns = -APART_NS

    def begin(self, now_ns: int, cause: Reason) -> None:
        """The arm begins to wait; what the operator causes with the clutch is no trouble."""
        self._repeated = now_ns - self._troubled_ns < APART_NS
        self.clutched = cause.code in OF_CLUTCH
        if not self.clutched:
            self._troubled_ns = now_ns
        self._of_age = now_ns - self._diverted_ns > BEFORE_NS
        self.began_ns = now_ns

    def note(self, cause: Reason) -> None:
        """Take note of what is wrong: only the age of samples leaves the origins as they are."""
        self._of_age = self._of_age and cause.code in OF_AGE
        self.clutched = self.clutched or cause.code in OF_CLUTCH

    def prolong(self, now_ns: int) -> None:
        """The operator holds the clutch: however long that lasts, the longest hold counts from its end."""
        self.began_ns, self._repeated = now_ns, False

    def divert(self, now_ns: int) -> None:
        """Take note that the driver began a stop by itself."""
        self._diverted_ns = now_ns
        self._of_age = False

    def too_long(self, now_ns: int, cause: Reason) -> Reason | None:
        """Say why the engagement ends; None while it need not."""
        if now_ns - self.began_ns >= self._longest_ns:
            return reason(Code.HELD_TOO_LONG, limit_ms=self._longest_ns / NS_PER_MS, cause=cause.sentence)
        return None

    def unearned(self, now_ns: int) -> Reason | None:
        """Say why the arm waits although nothing is wrong now: after a hold shortly before it, it waits for longer."""
        held_ns = now_ns - self.began_ns
        if not self._repeated or held_ns >= LEAST_NS:
            return None
        return reason(Code.UNSTEADY, held_ms=held_ns / NS_PER_MS, least_ms=LEAST_NS / NS_PER_MS)

    def short(self, now_ns: int) -> bool:
        """Return whether the arm may go on to the same origins: only samples came late, and not for long."""
        return self._of_age and now_ns - self.began_ns <= SHORT_NS
