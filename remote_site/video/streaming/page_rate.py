"""The rate of pictures that the operator's page keeps up with, from what came and what it painted; pure."""

import statistics
from collections.abc import Sequence

from common.clock import NS_PER_MS, NS_PER_S
from common.messages.video import ViewShown
from remote_site.video.streaming.link_rate import Least

SKIPS, COUNTED = 0.15, 1.0  # of what comes: a page that paints so much less is behind; rates are whole pictures
BEHIND_MS = 40.0  # and so is one that paints this much later than it has of late, and than by the time between pictures
PROMPT_MS = 60.0  # one that has never painted earlier than this is behind too
BEHIND_REPORTS = 3
REDUCED = 0.85  # of what it paints while it is behind
SETTLE_NS = 1500 * NS_PER_MS  # rates are counted over a second
CAUTIOUS_NS = 1500 * NS_PER_MS  # after that: then the cause may have ended, and the rate grows as if it had
CAUTION = 0.7, 1.3  # of the rate at which it last fell behind: between these the rate grows slowly at first
GROWTH_PER_S, CAUTIOUS_GROWTH_PER_S = 3.0, 1.04
LEAST_FPS = 5.0
MS_PER_S = 1000.0


class PageRate:
    """A limit of the rate of every camera; None while the page keeps up with all.

    A page that cannot keep up skips pictures, and each of them has cost the host that draws it processor time. Near the
    rate at which it fell behind it is given more slowly at first, then quickly, as TCP does (CUBIC, RFC 9438): all
    comes again within five seconds of the cause's end.
    """

    def __init__(self) -> None:
        self.fps: float | None = None
        self._behind_reports = 0
        self._least_lag_ms = Least()
        self._settled_ns = 0
        self._report_ns = 0
        self._too_much_fps = 0.0

    def report(self, views: Sequence[ViewShown], full_fps: float, now_ns: int) -> None:
        """Take in what the page has shown of each camera, and the rate that the cameras have."""
        passed_ns, self._report_ns = min(now_ns - self._report_ns, NS_PER_S), now_ns
        painted, came = (statistics.fmean(rates) for rates in zip(*((v.fps, v.came.fps) for v in views), strict=True))
        lag_ms = statistics.median(view.age_ms - view.came.age_ms for view in views)
        prompt_ms = min(PROMPT_MS, self._least_lag_ms.see(lag_ms, now_ns))
        skips = came - painted > max(SKIPS * came, COUNTED)
        # Of pictures that are farther apart than they are late, fewer would show what has happened later still.
        behind = skips or lag_ms > prompt_ms + max(BEHIND_MS, MS_PER_S / (self.fps or full_fps))
        self._behind_reports = self._behind_reports + 1 if behind else 0
        if now_ns < self._settled_ns:
            return
        if self._behind_reports >= BEHIND_REPORTS:
            self._too_much_fps = self.fps or full_fps
            self.fps = min(max(LEAST_FPS, REDUCED * painted), self._too_much_fps)
            self._settled_ns = now_ns + SETTLE_NS
        elif not behind and self.fps is not None:
            more = self.fps * self._growth_per_s(self.fps, now_ns) ** (passed_ns / NS_PER_S)
            self.fps = more if more < full_fps else None

    def _growth_per_s(self, fps: float, now_ns: int) -> float:
        low, high = (fraction * self._too_much_fps for fraction in CAUTION)
        cautious = low < fps < high and now_ns < self._settled_ns + CAUTIOUS_NS
        return CAUTIOUS_GROWTH_PER_S if cautious else GROWTH_PER_S
