"""The codec, quality, size and rate of every camera, from what came to the operator's console and what it shows."""

from collections import deque
from collections.abc import Iterable, Mapping
from dataclasses import replace
from functools import partial

from common.clock import NS_PER_S
from common.link.channels import SHOWN
from common.messages.robot import VideoLink
from common.messages.video import Codec, VideoFrame, ViewsShown
from remote_site.video.config import VideoConfig
from remote_site.video.streaming.busy_hosts import BusyHosts
from remote_site.video.streaming.codec_choice import CodecChoice
from remote_site.video.streaming.link_rate import USED, Least, LinkRate
from remote_site.video.streaming.page_rate import LEAST_FPS, PageRate
from remote_site.video.streaming.sent_pictures import SentPictures, together
from remote_site.video.streaming.setting import StreamSetting, fit, fit_h264, most_h264_bytes
from remote_site.video.streaming.video_trouble import busy_host, narrow_link, slow_page

SENDING_NS = NS_PER_S
FLOOR_BYTES_PER_S = 500.0
OLDER_CONSOLES = 16
UNTOLD_NS = 3 * NS_PER_S  # within which a console that operates reports, also over a link with a long way
UNTOLD_SCALE = 0.5
FEW = 0.7  # of the pictures: so many fewer are worth a word


class FollowedConsole:
    """Which console's reports count, and when each was sent by this host's clock: the newest, until it is silent."""

    def __init__(self) -> None:
        self.session: int | None = None
        self._reported_ns = self._newest_told_ns = 0
        self._older: deque[int] = deque(maxlen=OLDER_CONSOLES)
        self._way_back = Least()

    def is_silent(self, now_ns: int) -> bool:
        """Return whether none has reported for a second."""
        return now_ns - self._reported_ns > SHOWN.stale_after_ns

    def passes_over(self, session: int, now_ns: int) -> bool:
        """Return whether this is an older console, while a newer one reports."""
        return session != self.session and session in self._older and not self.is_silent(now_ns)

    def follow(self, session: int, now_ns: int) -> bool:
        """Follow the console that has just reported; return whether it is another than before."""
        self._reported_ns = now_ns
        if session == self.session:
            return False
        if self.session is not None:
            self._older.append(self.session)
        self.forget()
        self.session = session
        return True

    def forget(self) -> None:
        """Follow none."""
        self.session, self._newest_told_ns, self._way_back = None, 0, Least()

    def told_ns(self, shown: ViewsShown, now_ns: int) -> int:
        """Compute when a report would have come without delay on its way back: that delay says nothing about pictures.

        Where the console's clock loses time that would be ever earlier, so it is never before the report before.
        """
        told_ns = shown.sent_ns + round(self._way_back.see(now_ns - shown.sent_ns, now_ns))
        self._newest_told_ns = max(self._newest_told_ns, told_ns)
        return self._newest_told_ns


class Adaptation:
    """The settings of all cameras, following the newest console that reports; full without any.

    Who has just begun to listen may be a console behind a narrow link, which can report only after pictures have come:
    until then, or for UNTOLD_NS, few and small ones are sent. All at once would fill the link for seconds.

    The link's rate follows from what comes to the console, and how late, but for what a processor of either host
    explains of that; the rate worth sending from what its page paints of that, and how much later. A console is
    followed until a newer one reports or it has been silent for a second. Viewers never report, so that they get what
    suits the operator's link. The budget is divided so that each camera has the same bytes a second, and what one does
    not need goes to the others.
    """

    def __init__(self, config: VideoConfig, *, h264: bool) -> None:
        """`h264` is whether it can be encoded here."""
        self._full = StreamSetting(config.quality, 1.0, config.fps)
        self._new_choice = partial(CodecChoice, config.codec, encodes=h264)
        self._sent = {camera.name: SentPictures() for camera in config.cameras}
        self._listened_ns: int | None = -UNTOLD_NS
        self._console = FollowedConsole()
        self._begin()

    def sent(self, frame: VideoFrame, now_ns: int) -> None:
        """Note a message that was sent."""
        if frame.data:
            self._sent[frame.camera].send(frame, self.setting(frame.camera, now_ns), now_ns)

    def hold_back(self, camera: str) -> None:
        """Note a picture that was not sent because the camera's last one still waits in this host."""
        self._sent[camera].hold_back()

    def listened(self, now_ns: int, *, has_listener: bool) -> None:
        """Take note of whether anybody receives the pictures now."""
        if not has_listener:
            self._listened_ns = None
        elif self._listened_ns is None:
            self._listened_ns = now_ns

    def wait(self, waited_ms: float) -> None:
        """Note for how long this process has lately waited for its processor."""
        self._hosts.of_cell_ms = waited_ms

    def update(self, shown: ViewsShown, now_ns: int) -> None:
        """Take a console's report of what it has shown."""
        if self._console.passes_over(shown.session, now_ns):
            return
        if self._console.follow(shown.session, now_ns):
            self._begin()
        self._hosts.report(shown.waited_ms, now_ns)
        told_ns = self._console.told_ns(shown, now_ns)
        views = {name: view for name, view in shown.views.items() if name in self._sent}
        came = [one for name, view in views.items() if (one := self._sent[name].come(view.came, told_ns)) is not None]
        if came:
            self._page.report(list(views.values()), self._full.fps, now_ns)
            cautious, wanted = self._choice.codec is Codec.H264, sum(self._wanted(now_ns).values())
            self._link.report(together(came, self._hosts.waited_ms), wanted, told_ns, cautious=cautious)
        self._choose_codec(decodes=shown.h264, now_ns=now_ns)
        self._settings = self._chosen(self._wanted(now_ns))

    def setting(self, camera: str, now_ns: int) -> StreamSetting:
        """Return how the camera's next picture is to be sent."""
        if self._console.session is not None and self._console.is_silent(now_ns):
            self.forget()
        setting = self._settings[camera]
        if self._console.session is None and (self._listened_ns is None or now_ns - self._listened_ns < UNTOLD_NS):
            return replace(setting, scale=UNTOLD_SCALE, fps=min(LEAST_FPS, setting.fps))
        return setting

    def forget(self) -> None:
        """Follow no console, until one reports again."""
        self._console.forget()
        self._begin()

    def trouble(self, now_ns: int) -> VideoLink | None:
        """Say what of link, page or processor keeps pictures from coming all and in time; None where nothing does."""
        carries, wanted = self._link.carries, self._wanted(now_ns)
        needs = sum(wanted.values())
        if carries is not None and carries * USED < needs:
            narrow = narrow_link(carries, needs, self._full, [self._settings[name] for name in wanted])
            if narrow is not None:
                return narrow
        if (busy := self._hosts.busy(now_ns)) is not None:
            return busy_host(*busy, needs)
        fps = self._page.fps
        return slow_page(fps, self._full.fps, needs) if fps is not None and fps < FEW * self._full.fps else None

    def _begin(self) -> None:
        """Know nothing yet of the console that is followed, or of none."""
        self._link, self._page, self._hosts = LinkRate(), PageRate(), BusyHosts()
        self._choice = self._new_choice()
        self._settings = dict.fromkeys(self._sent, replace(self._full, codec=self._choice.codec))
        for sent in self._sent.values():
            sent.forget()

    def _choose_codec(self, *, decodes: bool, now_ns: int) -> None:
        link, wanted = self._link, sum(self._wanted_as_jpeg(now_ns).values())
        budget = link.budget(wanted)
        narrow = budget is not None and budget * link.draining < wanted
        opening, late_ns = link.is_opening, link.full_ns
        if self._choice.follow(decodes=decodes, opening=opening, narrow=narrow, late_ns=late_ns, now_ns=now_ns):
            link.assume_free()

    def _wanted(self, now_ns: int) -> dict[str, float]:
        """The bytes a second that each camera that sends would take at full quality."""
        if self._choice.codec is Codec.JPEG:
            return self._wanted_as_jpeg(now_ns)
        return {
            name: self._full.fps * most_h264_bytes(sent.pixels)
            for name, sent in self._sent.items()
            if sent.pixels is not None and now_ns - sent.sent_ns < SENDING_NS
        }

    def _wanted_as_jpeg(self, now_ns: int) -> dict[str, float]:
        per_reference = self._full.relative_bytes * self._full.fps
        return {
            name: sent.reference_bytes * per_reference
            for name, sent in self._sent.items()
            if sent.reference_bytes is not None and now_ns - sent.sent_ns < SENDING_NS
        }

    def _chosen(self, wanted: Mapping[str, float]) -> dict[str, StreamSetting]:
        link, codec = self._link, self._choice.codec
        budget = link.budget(sum(wanted.values()))
        fps = self._full.fps if self._page.fps is None else self._page.fps
        paced = replace(self._full, fps=fps, codec=codec)
        if budget is None:
            paced = replace(paced, fps=max(LEAST_FPS, paced.fps * link.draining))
            return dict.fromkeys(self._sent, paced)
        if codec is Codec.JPEG:
            budget *= link.draining
        most = max(fair_limit(wanted.values(), budget), FLOOR_BYTES_PER_S)
        fitted = self._fit_h264 if codec is Codec.H264 else self._fit_jpeg
        return self._settings | {name: fitted(name, most, wants, paced) for name, wants in wanted.items()}

    def _fit_jpeg(self, name: str, most: float, wants: float, paced: StreamSetting) -> StreamSetting:
        per_reference = self._full.relative_bytes * self._full.fps
        return fit(most, wants / per_reference, paced, self._settings[name])

    def _fit_h264(self, name: str, most: float, _wants: float, paced: StreamSetting) -> StreamSetting:
        """A link that is full is emptied by fewer pictures, since smaller ones would take a new encoder."""
        fitted = fit_h264(most, self._sent[name].pixels or 1, paced, self._settings[name])
        return replace(fitted, fps=min(fitted.fps, max(LEAST_FPS, fitted.fps * self._link.draining)))


def fair_limit(wanted: Iterable[float], budget: float) -> float:
    """The limit at which a budget is used up, if every consumer takes what it wants up to the limit (max-min fair)."""
    left, ordered = budget, sorted(wanted)
    for k, wants in enumerate(ordered):
        limit = left / (len(ordered) - k)
        if wants >= limit:
            return limit
        left -= wants
    return budget
