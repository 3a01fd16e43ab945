"""Causes of pictures that are not sent or come late, in words with the cure: link, page or a host's processor; pure."""

from collections.abc import Collection

from common.messages.robot import VideoLink, VideoTrouble
from common.messages.video import Codec
from remote_site.video.streaming.busy_hosts import Host
from remote_site.video.streaming.setting import StreamSetting

MBIT_PER_BYTE = 8e-6
NUMBERS = ("no", "one", "two", "three", "four", "five", "six")


def narrow_link(
    carries: float, needs: float, full: StreamSetting, settings: Collection[StreamSetting]
) -> VideoLink | None:
    """Say what is wrong where the link `carries` fewer bytes a second than the cameras need at the full setting.

    `settings` are those that are sent; None while they are all the full one, or H.264 of the same size and rate.
    """
    if all(setting == full or _is_whole(setting, full) for setting in settings):
        return None
    carries_mbit_s, needs_mbit_s = carries * MBIT_PER_BYTE, needs * MBIT_PER_BYTE
    count = NUMBERS[len(settings)] if len(settings) < len(NUMBERS) else str(len(settings))
    views = f"the {count} views need" if len(settings) > 1 else "the view needs"
    reason = (
        f"the link carries {carries_mbit_s:.1f} Mbit/s of pictures; {views} about {needs_mbit_s:.0f} Mbit/s at "
        f"{_words(full)}: they are sent at {_words(_least(settings))}. Cure: a wider link, lower video.fps or "
        "video.quality, or fewer cameras"
    )
    return VideoLink(carries_mbit_s=carries_mbit_s, needs_mbit_s=needs_mbit_s, reason=reason)


def slow_page(fps: float, full_fps: float, needs: float) -> VideoLink:
    """The page paints no more than `fps` in time; all would need so many bytes a second."""
    reason = (
        f"the operator's page paints {fps:.0f} of {full_fps:.0f} pictures a second in time: no more are sent. "
        "Cure: fewer programs on the operator's host, a browser that draws with its graphics card, fewer cameras, or a "
        "lower video.fps"
    )
    return _of_other_cause(VideoTrouble.SLOW_PAGE, needs * fps / full_fps, needs, reason)


def busy_host(host: Host, waited_ms: float, needs: float) -> VideoLink:
    """This host's processor keeps pictures waiting for so long."""
    whose = "the operator's host" if host is Host.OPERATOR else "the cell's host"
    reason = (
        f"the processor of {whose} is full: pictures wait for it, {waited_ms:.0f} ms lately. "
        f"Cure: fewer programs on {whose}, a faster one, fewer cameras, or a lower video.fps"
    )
    return _of_other_cause(VideoTrouble.BUSY_HOST, needs, needs, reason)


def _of_other_cause(code: VideoTrouble, sent: float, needs: float, reason: str) -> VideoLink:
    return VideoLink(carries_mbit_s=sent * MBIT_PER_BYTE, needs_mbit_s=needs * MBIT_PER_BYTE, reason=reason, code=code)


def _is_whole(setting: StreamSetting, full: StreamSetting) -> bool:
    """H.264 at full size and rate: nothing is missing."""
    return setting.codec is Codec.H264 and (setting.scale, setting.fps) == (full.scale, full.fps)


def _least(settings: Collection[StreamSetting]) -> StreamSetting:
    return StreamSetting(
        min(setting.quality for setting in settings),
        min(setting.scale for setting in settings),
        min(setting.fps for setting in settings),
    )


def _words(setting: StreamSetting) -> str:
    size = "full size" if setting.scale == 1.0 else f"{setting.scale:.0%} of the size"
    return f"quality {setting.quality}, {size}, {setting.fps:.0f} fps"
