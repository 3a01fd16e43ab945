"""A live camera's frame for the links, made of nothing but its picture."""

from common.messages.video import CameraStatus, VideoFrame


def live_frame(camera: str, seq: int, capture_ns: int, jpeg: bytes, size_px: tuple[int, int] = (1, 1)) -> VideoFrame:
    """A frame (width, height) whose capture time is known."""
    width, height = size_px
    return VideoFrame(
        camera=camera,
        seq=seq,
        capture_ns=capture_ns,
        capture_estimated=False,
        status=CameraStatus.LIVE,
        reason="",
        width=width,
        height=height,
        jpeg=jpeg,
    )
