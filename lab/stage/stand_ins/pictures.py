"""Files of what arrived at a console and its page: whole picture messages, and a line for each one shown."""

import struct
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from common.link.channels import CAMERA
from common.messages.codec import decode, encode
from common.messages.video import VideoFrame

HEAD = struct.Struct("<qI")  # when it arrived, ns; length of the message


class PictureLog:
    """Appends whole picture messages to a file, as they arrived at a console."""

    def __init__(self, path: Path) -> None:
        self._file = path.open("ab", buffering=0)

    def add(self, frame: VideoFrame, now_ns: int) -> None:
        """Keep a message."""
        message = encode(frame)
        self._file.write(HEAD.pack(now_ns, len(message)) + message)

    def close(self) -> None:
        """Close the file."""
        self._file.close()


def read_pictures(path: Path) -> Iterator[tuple[int, VideoFrame]]:
    """Every whole message in the order of arrival, with its time in ns."""
    with path.open("rb") as file:
        while len(head := file.read(HEAD.size)) == HEAD.size:
            arrived_ns, size = HEAD.unpack(head)
            message = file.read(size)
            if len(message) == size:
                yield arrived_ns, decode(message, VideoFrame, CAMERA.max_bytes)


@dataclass(frozen=True, slots=True)
class SeenPictures:
    """A picture that reached the page: which, when (ns), and its age as the page had to believe it, at most (ms).

    The age is None while the page did not know the offset of the clocks.
    """

    camera: str
    seq: int
    seen_ns: int
    oldest_ms: float | None


class SightLog:
    """Appends a line for each picture that reached a page."""

    def __init__(self, path: Path) -> None:
        self._file = path.open("a", buffering=1)

    def add(self, sight: SeenPictures) -> None:
        """Keep a line."""
        oldest_ms = "" if sight.oldest_ms is None else f"{sight.oldest_ms:.3f}"
        self._file.write(f"{sight.camera},{sight.seq},{sight.seen_ns},{oldest_ms}\n")

    def close(self) -> None:
        """Close the file."""
        self._file.close()


def read_sights(path: Path) -> list[SeenPictures]:
    """Every whole line."""
    lines = [line for line in path.read_text().splitlines(keepends=True) if line.endswith("\n")]
    fields = [line.strip().split(",") for line in lines]
    return [
        SeenPictures(camera, int(seq), int(seen_ns), float(oldest) if oldest else None)
        for camera, seq, seen_ns, oldest in fields
    ]
