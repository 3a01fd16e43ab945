"""The quality, size and rate of every camera, from what came to the operator's console and what it shows."""

import statistics
from collections import deque
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace

from common.clock import NS_PER_S
from common.link.channels import SHOWN
from common.messages.video import VideoFrame, ViewsShown
from remote_site.video.config import VideoConfig
from remote_site.video.streaming.link_rate import Arrivals, LinkRate, SentPictures
from remote_site.video.streaming.page_rate import PageRate
from remote_site.video.streaming.setting import StreamSetting, fit

SENDING_NS = NS_PER_S
FLOOR_BYTES_PER_S = 500.0
OLDER_CONSOLES = 16


class Adaptation:
    """The settings of all cameras, following the newest console that reports; full without any.

    The link's rate follows from what comes to the console, and how late; the rate worth sending from what its page
    paints of that, and how much later. A console is followed until a newer one reports or it has been silent for a
    second. Viewers never report, so that they get what suits the operator's link. The budget is divided so that each
    camera has the same bytes a second, and what one does not need goes to the others.
    """

    def __init__(self, config: VideoConfig) -> None:
        self._full = StreamSetting(config.quality, 1.0, config.fps)
        self._sent = {camera.name: SentPictures() for camera in config.cameras}
        self._settings = dict.fromkeys(self._sent, self._full)
        self._link, self._page = LinkRate(), PageRate()
        self._console: int | None = None
        self._reported_ns = 0
        self._older: deque[int] = deque(maxlen=OLDER_CONSOLES)

    def sent(self, frame: VideoFrame, now_ns: int) -> None:
        """Note a message that was sent."""
        if frame.jpeg:
            relative = self._settings[frame.camera].relative_bytes
            self._sent[frame.camera].send(frame.seq, len(frame.jpeg), relative, now_ns)

    def update(self, shown: ViewsShown, now_ns: int) -> None:
        """Take a console's report of what it has shown."""
        if not self._follow(shown.session, now_ns):
            return
        views = {name: view for name, view in shown.views.items() if name in self._sent}
        arrivals = [
            new for name, view in views.items() if (new := self._sent[name].come(view.came, now_ns)) is not None
        ]
        if not arrivals:
            return
        self._page.report(list(views.values()), self._full.fps, now_ns)
        wanted = self._wanted(now_ns)
        self._link.report(together(arrivals), sum(wanted.values()), now_ns)
        self._settings = self._chosen(wanted)

    def setting(self, camera: str, now_ns: int) -> StreamSetting:
        """How the camera's next picture is to be sent."""
        if self._console is not None and now_ns - self._reported_ns > SHOWN.stale_after_ns:
            self._forget(None)
        return self._settings[camera]

    def _follow(self, session: int, now_ns: int) -> bool:
        """Whether this console counts; the first report of a new one takes over."""
        silent = now_ns - self._reported_ns > SHOWN.stale_after_ns
        if session != self._console:
            if session in self._older and not silent:
                return False
            if self._console is not None:
                self._older.append(self._console)
            self._forget(session)
        self._reported_ns = now_ns
        return True

    def _forget(self, console: int | None) -> None:
        """Reset for another console, or for none."""
        self._console = console
        self._link, self._page = LinkRate(), PageRate()
        self._settings = dict.fromkeys(self._sent, self._full)
        for sent in self._sent.values():
            sent.forget()

    def _wanted(self, now_ns: int) -> dict[str, float]:
        """The bytes a second that each camera that sends would take at full quality."""
        per_reference = self._full.relative_bytes * self._full.fps
        return {
            name: sent.reference_bytes * per_reference
            for name, sent in self._sent.items()
            if sent.reference_bytes is not None and now_ns - sent.sent_ns < SENDING_NS
        }

    def _chosen(self, wanted: Mapping[str, float]) -> dict[str, StreamSetting]:
        budget = self._link.budget(sum(wanted.values()))
        paced = self._full if self._page.fps is None else replace(self._full, fps=self._page.fps)
        if budget is None:
            return dict.fromkeys(self._sent, paced)
        most = max(fair_limit(wanted.values(), budget), FLOOR_BYTES_PER_S)
        per_reference = self._full.relative_bytes * self._full.fps
        return self._settings | {
            name: fit(most, wants / per_reference, paced, self._settings[name]) for name, wants in wanted.items()
        }


def fair_limit(wanted: Iterable[float], budget: float) -> float:
    """The limit at which a budget is used up, if every consumer takes what it wants up to the limit (max-min fair)."""
    left, ordered = budget, sorted(wanted)
    for k, wants in enumerate(ordered):
        limit = left / (len(ordered) - k)
        if wants >= limit:
            return limit
        left -= wants
    return budget


def together(arrivals: Sequence[Arrivals]) -> Arrivals:
    """All cameras as one: sums of bytes, medians of times, so that one late camera is not a late link."""
    return Arrivals(
        sum(one.sent_bytes for one in arrivals),
        sum(one.carried_bytes for one in arrivals),
        sum(one.waiting_bytes for one in arrivals),
        statistics.median(one.delay_ms for one in arrivals),
        statistics.median(one.least_age_ms for one in arrivals),
    )
