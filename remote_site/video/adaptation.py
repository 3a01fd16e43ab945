"""What came to the operator's console, and what it shows, decide the quality, size and rate of every camera. Pure."""

import statistics
from collections import deque
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace

from common.clock import NS_PER_S
from common.link.channels import SHOWN
from common.messages.video import VideoFrame, ViewsShown
from remote_site.video.carrying import Carrying, News
from remote_site.video.config import VideoConfig
from remote_site.video.ledger import Ledger
from remote_site.video.page_pace import PagePace
from remote_site.video.setting import StreamSetting, fit

SENDING_NS = NS_PER_S
FLOOR_BYTES_PER_S = 500.0
OLDER_CONSOLES = 16


class Adaptation:
    """The settings of all cameras, following the newest console that reports; full without any.

    What comes to the console, and how late, tells what the link carries; what its page paints of that, and how much
    later, at what rate it is worth sending. A console is followed until a newer one reports or it has been silent for a
    second. Viewers never report, so that they get what suits the operator's link. The budget is shared so that each
    camera has the same bytes a second, and what one does not need goes to the others.
    """

    def __init__(self, config: VideoConfig) -> None:
        self._full = StreamSetting(config.quality, 1.0, config.fps)
        self._ledgers = {camera.name: Ledger() for camera in config.cameras}
        self._settings = dict.fromkeys(self._ledgers, self._full)
        self._carrying, self._pace = Carrying(), PagePace()
        self._console: int | None = None
        self._heard_ns = 0
        self._older: deque[int] = deque(maxlen=OLDER_CONSOLES)

    def sent(self, frame: VideoFrame, now_ns: int) -> None:
        """A message went out."""
        if frame.jpeg:
            relative = self._settings[frame.camera].relative_bytes
            self._ledgers[frame.camera].send(frame.seq, len(frame.jpeg), relative, now_ns)

    def hear(self, shown: ViewsShown, now_ns: int) -> None:
        """A console says what it has shown."""
        if not self._follow(shown.session, now_ns):
            return
        news = [
            told
            for name, view in shown.views.items()
            if name in self._ledgers and (told := self._ledgers[name].come(view.came, now_ns)) is not None
        ]
        if not news:
            return
        known = [view for name, view in shown.views.items() if name in self._ledgers]
        self._pace.report(known, self._full.fps, now_ns)
        wanted = self._wanted(now_ns)
        self._carrying.report(together(news), sum(wanted.values()), now_ns)
        self._settings = self._chosen(wanted)

    def setting(self, camera: str, now_ns: int) -> StreamSetting:
        """How the camera's next picture is to be sent."""
        if self._console is not None and now_ns - self._heard_ns > SHOWN.stale_after_ns:
            self._forget(None)
        return self._settings[camera]

    def _follow(self, session: int, now_ns: int) -> bool:
        """Whether this console counts; the first word of a new one takes over."""
        silent = now_ns - self._heard_ns > SHOWN.stale_after_ns
        if session != self._console:
            if session in self._older and not silent:
                return False
            if self._console is not None:
                self._older.append(self._console)
            self._forget(session)
        self._heard_ns = now_ns
        return True

    def _forget(self, console: int | None) -> None:
        """Begin anew with another console, or with none."""
        self._console = console
        self._carrying, self._pace = Carrying(), PagePace()
        self._settings = dict.fromkeys(self._ledgers, self._full)
        for ledger in self._ledgers.values():
            ledger.forget()

    def _wanted(self, now_ns: int) -> dict[str, float]:
        """The bytes a second that each camera that sends would take at full quality."""
        per_reference = self._full.relative_bytes * self._full.fps
        return {
            name: ledger.reference_bytes * per_reference
            for name, ledger in self._ledgers.items()
            if ledger.reference_bytes is not None and now_ns - ledger.sent_ns < SENDING_NS
        }

    def _chosen(self, wanted: Mapping[str, float]) -> dict[str, StreamSetting]:
        budget = self._carrying.budget(sum(wanted.values()))
        paced = self._full if self._pace.fps is None else replace(self._full, fps=self._pace.fps)
        if budget is None:
            return dict.fromkeys(self._ledgers, paced)
        share = fair_share(wanted.values(), budget)
        per_reference = self._full.relative_bytes * self._full.fps
        return self._settings | {
            name: fit(max(share, FLOOR_BYTES_PER_S), wants / per_reference, paced, self._settings[name])
            for name, wants in wanted.items()
        }


def fair_share(wanted: Iterable[float], budget: float) -> float:
    """The largest share of which nobody gets more, if everybody gets what he wants up to it."""
    left, ordered = budget, sorted(wanted)
    for k, wants in enumerate(ordered):
        share = left / (len(ordered) - k)
        if wants >= share:
            return share
        left -= wants
    return budget


def together(news: Sequence[News]) -> News:
    """The news of all cameras as one: sums of bytes, medians of times, so that one late camera is not a late link."""
    return News(
        sum(told.sent_bytes for told in news),
        sum(told.carried_bytes for told in news),
        sum(told.waiting_bytes for told in news),
        statistics.median(told.delay_ms for told in news),
        statistics.median(told.least_age_ms for told in news),
    )
