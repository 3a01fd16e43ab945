"""In the place of the operator's views the console gets the reason, several times a second, and nobody else does."""

from common.clock import NS_PER_MS
from common.messages.video import CameraStatus, VideoFrame
from local_site.preview.preview import MAX_REASON, NoCamera


class Wire:
    def __init__(self, has_listener: bool = True) -> None:
        self.has_listener = has_listener
        self.sent: list[VideoFrame] = []

    def put(self, message: VideoFrame) -> None:
        self.sent.append(message)


def test_who_looks_is_told_why_at_a_slow_pace() -> None:
    left, right = Wire(), Wire(has_listener=False)
    views = NoCamera({"left": left, "right": right}, "a taught path is run" + "!" * 500)
    for ms in range(0, 2000, 17):
        views.tell(ms * NS_PER_MS)
    assert 6 <= len(left.sent) <= 8
    assert right.sent == []
    assert [m.seq for m in left.sent] == sorted({m.seq for m in left.sent})
    assert {(m.camera, m.status, m.data) for m in left.sent} == {("left", CameraStatus.MISSING, b"")}
    assert left.sent[0].reason.startswith("a taught path is run!")
    assert len(left.sent[0].reason) == MAX_REASON
