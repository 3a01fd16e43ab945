"""The operator's page: what it has set under the lease in force, its clutch, and whether it still reports; pure."""

import math

from common.clock import NS_PER_MS
from common.geometry import angle_between
from common.messages.clutch_latch import ClutchLatch
from common.messages.hand import ClutchKey, HandArm, Intent, OperatorSettings
from remote_site.reasons import Code, Reason, reason
from remote_site.session.hand_signal import REPEATS
from remote_site.session.samples import Accepted, Rejected

CALM_NS = 200 * NS_PER_MS
CALM_M, CALM_RAD = 0.015, math.radians(10.0)  # a calm hand moves less in this time
HELD = reason(Code.CLUTCHED)
UNSEEN = reason(Code.CLUTCH_UNSEEN)
SETTLING = reason(Code.CLUTCH_SETTLING, calm_ms=CALM_NS / NS_PER_MS)


class Clutch:
    """The arm waits while the clutch is held, and after its release until the hand was seen calm.

    Feed it every judged sample; the state of the key is part of it, so one that is lost or late ends nothing.
    """

    def __init__(self) -> None:
        self._latch = ClutchLatch()
        self._released_ns: int | None = None  # by the sender's clock, until the hand was calm
        self._calm: tuple[Accepted, Accepted] | None = None  # the first and the newest of a calm hand

    def observe(self, result: Accepted | Rejected, gap_ns: int) -> None:
        """Take note of a judged sample; between two that are farther apart than `gap_ns` nobody saw the hand."""
        if result.sample is not None:
            self._see(result.sample)
        if self._released_ns is None:
            return
        if isinstance(result, Accepted):
            self._settle(result, self._released_ns, gap_ns)
        elif result.reason.code not in REPEATS:
            self._calm = None

    def reason(self) -> Reason | None:
        """Say why the arm waits; None while it need not."""
        if self._latch.key is ClutchKey.DOWN:
            return HELD
        if self._latch.key is ClutchKey.UNSEEN:
            return UNSEEN
        return SETTLING if self._released_ns is not None else None

    def _see(self, sample: HandArm) -> None:
        was_up = self._latch.key is ClutchKey.UP
        if sample.intent is None:
            self._latch.interrupt()
        else:
            self._latch.see(sample.intent.clutch)
        if self._latch.key is not ClutchKey.UP:
            self._released_ns = self._calm = None
        elif not was_up:  # what the sample shows of the hand is from before it was sent
            self._released_ns = sample.sent_ns if sample.sent_ns is not None else sample.capture_ns

    def _settle(self, newest: Accepted, released_ns: int, gap_ns: int) -> None:
        if newest.sample.capture_ns < released_ns:
            return
        first, last = self._calm or (newest, newest)
        if newest.born_ns - last.born_ns > gap_ns or _moved(first, newest):
            first = newest
        self._calm = first, newest
        if newest.born_ns - first.born_ns >= CALM_NS:
            self._released_ns = self._calm = None


def _moved(first: Accepted, newest: Accepted) -> bool:
    """Return whether the hand has moved, turned, opened or closed from one sample to another."""
    if math.dist(first.position.tolist(), newest.position.tolist()) > CALM_M:
        return True
    if first.sample.hand_open != newest.sample.hand_open:
        return True
    before, now = first.operator_R_hand, newest.operator_R_hand
    if before is None or now is None:
        return before is not now  # it is withheld while the hand turns too fast
    return angle_between(before, now) > CALM_RAD


class OperatorPage:
    """Keeps `settings` under the number of their lease, whatever happens to the page, console or pedal that sent them.

    Only a higher revision under the same lease replaces them: a console that starts again cannot overwrite them by
    defaults, nor one that has missed a change.
    """

    def __init__(self) -> None:
        self.settings = OperatorSettings()
        self.clutch = Clutch()
        self._has_reported = self._reports = False

    @property
    def silent(self) -> bool:
        """A page has reported under this lease, and the newest sample comes without it."""
        return self._has_reported and not self._reports

    def begin(self, lease: int) -> None:
        """Take note of the number of the lease in force; a new one begins with the defaults, and without a page."""
        if lease != self.settings.lease:
            self.settings = OperatorSettings(lease=lease)
            self.clutch = Clutch()
            self._has_reported = self._reports = False

    def see(self, intent: Intent | None) -> None:
        """Take what the page reported for the newest sample, None where it reported nothing."""
        self._reports = intent is not None
        self._has_reported = self._has_reported or self._reports
        self.settings = self.settings.followed_by(intent.settings if intent is not None else None)
