"""Pictures that do not all arrive, in words: how much does, what they need, how they are sent instead; pure."""

from collections.abc import Collection

from common.messages.robot import VideoLink
from common.messages.video import Codec
from remote_site.video.streaming.setting import StreamSetting

MBIT_PER_BYTE = 8e-6
NUMBERS = ("no", "one", "two", "three", "four", "five", "six")


def narrow_link(
    carries: float, needs: float, full: StreamSetting, settings: Collection[StreamSetting]
) -> VideoLink | None:
    """What is wrong where the link `carries` fewer bytes a second than the cameras need at the full setting.

    `settings` are those that are sent; None while they are all the full one, or H.264 of the same size and rate.
    """
    if all(setting == full or _is_whole(setting, full) for setting in settings):
        return None
    carries_mbit_s, needs_mbit_s = carries * MBIT_PER_BYTE, needs * MBIT_PER_BYTE
    count = NUMBERS[len(settings)] if len(settings) < len(NUMBERS) else str(len(settings))
    views = f"the {count} views need" if len(settings) > 1 else "the view needs"
    reason = (
        f"{carries_mbit_s:.1f} Mbit/s of pictures arrive; {views} about {needs_mbit_s:.0f} Mbit/s at "
        f"{_words(full)}: they are sent at {_words(_least(settings))}. The link is too narrow, or a host overloaded. "
        "Cure: a wider link, fewer programs on that host, lower video.fps or video.quality, or fewer cameras"
    )
    return VideoLink(carries_mbit_s=carries_mbit_s, needs_mbit_s=needs_mbit_s, reason=reason)


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
