"""JPEG while the link carries it, H.264 before pictures suffer, JPEG where H.264 is not to be had."""

from itertools import pairwise

import pytest

from common.clock import NS_PER_S
from common.messages.video import Codec
from remote_site.video.streaming.codec_choice import LONGEST_RETRY_NS, RETRY_NS, CodecChoice, CodecPreference

AUTO, JPEG, H264 = CodecPreference.AUTO, CodecPreference.JPEG, CodecPreference.H264
STEP_NS = NS_PER_S


@pytest.mark.parametrize(
    ("preference", "encodes", "decodes", "narrow", "codec"),
    [
        (AUTO, True, True, False, Codec.JPEG),
        (AUTO, True, True, True, Codec.H264),
        (AUTO, True, False, True, Codec.JPEG),
        (AUTO, False, True, True, Codec.JPEG),
        (JPEG, True, True, True, Codec.JPEG),
        (H264, True, True, False, Codec.H264),
        (H264, True, False, False, Codec.H264),
    ],
)
def test_the_codec_follows_from_what_is_configured_installed_decoded_and_carried(
    preference: CodecPreference, encodes: bool, decodes: bool, narrow: bool, codec: Codec
) -> None:
    choice = CodecChoice(preference, encodes=encodes)
    for opening in (True, False, False):
        choice.follow(decodes=decodes, opening=opening, narrow=narrow or opening, late_ns=0, now_ns=STEP_NS)
    assert choice.codec is codec


def test_while_nothing_is_known_of_the_link_it_is_h264() -> None:
    choice = CodecChoice(AUTO, encodes=True)
    choice.follow(decodes=True, opening=True, narrow=True, late_ns=0, now_ns=0)
    assert choice.codec is Codec.H264


def test_a_page_that_decodes_no_h264_gets_jpeg_at_once() -> None:
    choice = CodecChoice(AUTO, encodes=True)
    choice.follow(decodes=True, opening=False, narrow=True, late_ns=0, now_ns=0)
    choice.follow(decodes=False, opening=False, narrow=True, late_ns=0, now_ns=1)
    assert choice.codec is Codec.JPEG


def trials(carries_jpeg: bool, seconds: int, late_s: int = 0) -> list[int]:
    """When JPEG is tried (s) on a link that has become narrow, and was late until `late_s`."""
    choice, tried = CodecChoice(AUTO, encodes=True), []
    for k in range(seconds):
        narrow = k < 2 or (choice.codec is Codec.JPEG and not carries_jpeg)
        late_ns = min(k, late_s) * NS_PER_S
        if choice.follow(decodes=True, opening=False, narrow=narrow, late_ns=late_ns, now_ns=k * NS_PER_S):
            tried.append(k)
    return tried


def test_jpeg_is_tried_after_a_quiet_minute_and_stays_where_the_link_carries_it() -> None:
    assert trials(carries_jpeg=True, seconds=4000) == [60]
    assert trials(carries_jpeg=True, seconds=4000, late_s=45) == [105]


def test_trials_that_fail_become_rarer_up_to_sixteen_minutes() -> None:
    tried = trials(carries_jpeg=False, seconds=8000)
    apart_s = [after - before for before, after in pairwise(tried)]
    assert apart_s[:5] == [121, 241, 481, 961, 961]
    assert tried[0] == RETRY_NS // NS_PER_S
    assert max(apart_s) <= LONGEST_RETRY_NS // NS_PER_S + 1
