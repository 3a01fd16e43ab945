"""A console asks for a key frame at once, and again while none comes."""

from itertools import pairwise

from common.clock import NS_PER_MS
from common.messages.video import KeyFrameRequest
from local_site.console.key_frames import REPEAT_NS, KeyFrames


def test_a_request_goes_out_at_once_and_is_repeated_with_the_newest_number() -> None:
    sent: list[tuple[int, KeyFrameRequest]] = []
    now_ns = 0
    keys = KeyFrames(lambda request: sent.append((now_ns, request)))
    for k in range(10):  # pictures come, and no page can decode any
        now_ns = 10**9 + k * 33 * NS_PER_MS
        keys.ask("side", 40 + k, now_ns)
    assert [request.after_seq for _, request in sent] == [40, 44, 48]
    assert sent[0][0] == 10**9
    assert min(after[0] - before[0] for before, after in pairwise(sent)) >= REPEAT_NS


def test_each_camera_is_asked_for_by_itself() -> None:
    sent: list[KeyFrameRequest] = []
    keys = KeyFrames(sent.append)
    for camera in ("side", "front"):
        keys.ask(camera, 7, 10**9)
    assert sent == [KeyFrameRequest(camera="side", after_seq=7), KeyFrameRequest(camera="front", after_seq=7)]
