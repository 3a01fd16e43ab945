"""Logs what the links allow: the age limit, and trouble once, again each minute while it lasts, and its end."""

import structlog

from common.clock import NS_PER_S
from common.messages.robot import HandLink, VideoLink

APART_NS = 3 * NS_PER_S  # near a limit trouble comes and goes
AGAIN_NS = 60 * NS_PER_S
HAND_EVENT, VIDEO_EVENT = "link of the hand", "link of the pictures"
TOO_SLOW = "link_too_slow"  # the code of readiness


class TroubleLog:
    """The lines of one event; a code that comes and goes is logged every three seconds at most."""

    def __init__(self, event: str) -> None:
        self._event = event
        self._code = ""
        self._logged_ns: int | None = None

    def note(self, code: str, reason: str, now_ns: int, **figures: float | str | None) -> None:
        """Note what is wrong now, with empty code and reason while nothing is."""
        since_ns = now_ns - self._logged_ns if self._logged_ns is not None else AGAIN_NS
        due = since_ns >= (APART_NS if code != self._code else AGAIN_NS)
        if not due or not (code or self._code):
            return
        self._code, self._logged_ns = code, now_ns
        log = structlog.get_logger()
        if code:
            log.warning(self._event, code=code, reason=reason, **figures)
        else:
            log.info(self._event, code="ok")


class LinkLog:
    """The links of a cell as the remote site has measured them: their trouble, and the age limit of the samples."""

    def __init__(self) -> None:
        self._hand, self._video = TroubleLog(HAND_EVENT), TroubleLog(VIDEO_EVENT)
        self._age_limit_ms: float | None = None
        self._too_slow = False

    def note_limit(self, age_limit_ms: float, speed: float, code: str, reason: str) -> None:
        """Note the age limit, the fraction of the speed that it leaves, and what engaging lacks."""
        if age_limit_ms != self._age_limit_ms:
            if self._age_limit_ms is not None:
                structlog.get_logger().info("age limit", ms=age_limit_ms, speed=f"{speed:.0%}")
            self._age_limit_ms = age_limit_ms
        too_slow = code == TOO_SLOW
        if too_slow and not self._too_slow:
            structlog.get_logger().warning("the link is too slow", reason=reason)
        self._too_slow = too_slow

    def note(self, hand: HandLink | None, video: VideoLink | None, now_ns: int) -> None:
        """Note the links as they are now; None where nothing is measured, or nothing is wrong."""
        if hand is not None:
            self._hand.note(hand.code, hand.reason, now_ns, **_figures(hand))
        if video is None:
            self._video.note("", "", now_ns)
        else:
            rates = {"carries_mbit_s": video.carries_mbit_s, "needs_mbit_s": video.needs_mbit_s}
            self._video.note(video.code, video.reason, now_ns, **{name: round(rate, 2) for name, rate in rates.items()})


def _figures(hand: HandLink) -> dict[str, float | None]:
    """The figures of a line: whole milliseconds, the loss to a tenth of a per cent."""
    times = {
        name: getattr(hand, name)
        for name in ("age_ms", "network_ms", "clock_ms", "tracking_ms", "interval_ms", "jitter_ms")
    }
    return {name: None if time is None else round(time) for name, time in times.items()} | {"loss": round(hand.loss, 3)}
