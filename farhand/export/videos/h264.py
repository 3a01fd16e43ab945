"""Pictures as H.264 in MP4: written, joined without encoding again; JPEG to pixels and back."""

from collections.abc import Sequence
from contextlib import suppress
from fractions import Fraction
from pathlib import Path

import av
import numpy as np
import simplejpeg
from numpy.typing import NDArray

from common.errors import ExportError
from farhand.export.session import MOST_PIXELS

Rgb = NDArray[np.uint8]
PIXELS = "yuv420p"
LONGEST_SIDE_PX = 16_384  # that x264 encodes
SUFFIX = ".mp4"


class H264File:
    """A video of constant rate (Hz), size (width, height); a key picture every `gop` pictures.

    Encoded by x264 with constant quality; without pictures that refer to later ones, so that files can be joined.
    ExportError for a size that it cannot encode. OSError of any call: nothing more can be written.
    """

    def __init__(self, path: Path, size_px: tuple[int, int], fps: int, gop: int, crf: int) -> None:
        check_size(size_px, path.stem)
        self._container = av.open(str(path), "w")
        options = {"crf": str(crf), "preset": "veryfast", "bf": "0", "threads": "1"}
        stream = self._container.add_stream("libx264", rate=fps, options=options)
        stream.width, stream.height = size_px
        stream.pix_fmt = PIXELS
        stream.gop_size = gop
        stream.codec_context.time_base = Fraction(1, fps)
        self._stream, self._count, self._failed = stream, 0, False

    def add(self, picture: Rgb) -> None:
        """Encode the next picture (height, width, 3), RGB."""
        frame = av.VideoFrame.from_ndarray(picture, format="rgb24")
        frame.pts = self._count
        frame.time_base = self._stream.codec_context.time_base
        self._count += 1
        self._write(frame)

    def finish(self) -> None:
        """Complete the file, or only close it where it could not be written."""
        if self._failed:
            with suppress(av.FFmpegError):  # which said so before
                self._container.close()
            return
        self._write(None)
        self._container.close()

    def _write(self, frame: av.VideoFrame | None) -> None:
        try:
            self._container.mux(self._stream.encode(frame))
        except av.FFmpegError:
            self._failed = True  # a header that failed must not be written again: that crashes the process
            raise


def check_size(size_px: tuple[int, int], what: str) -> None:
    """ExportError for pictures (width, height) that x264 does not encode."""
    width, height = size_px
    if width % 2 or height % 2 or not 0 < max(size_px) <= LONGEST_SIDE_PX:
        cure = "leave it out, naming other views with --view, or use 'farhand export csv', which takes no pictures"
        raise ExportError(
            f"'{what}' has {width}x{height} pixels, and H.264 takes even sizes of at most {LONGEST_SIDE_PX}; {cure}"
        )


def joined(parts: Sequence[Path], out: Path, fps: int) -> None:
    """Write videos of one kind and rate (Hz) one after the other, as they are encoded."""
    with av.open(str(out), "w") as target:
        stream: av.VideoStream | None = None
        begun = 0
        for part in parts:
            with av.open(str(part)) as source:
                given = source.streams.video[0]
                stream = stream or target.add_stream_from_template(given)
                packets = [packet for packet in source.demux(given) if packet.size]
                for packet in packets:
                    _move(packet, begun, fps)
                    packet.stream = stream
                    target.mux(packet)
                begun += len(packets)


def _move(packet: "av.Packet[av.VideoStream]", pictures: int, fps: int) -> None:
    """Show a packet later, by so many pictures."""
    shift = round(Fraction(pictures, fps) / packet.time_base)
    packet.pts = (packet.pts or 0) + shift
    packet.dts = (packet.dts or 0) + shift


def decoded(jpeg: bytes, what: str) -> Rgb:
    """The pixels (height, width, 3) of a JPEG, RGB; ExportError for what is none."""
    try:
        height, width, _, _ = simplejpeg.decode_jpeg_header(jpeg)
        if height * width > MOST_PIXELS:
            raise ValueError(f"{width} x {height} pixels, more than any camera gives")
        pixels: Rgb = simplejpeg.decode_jpeg(jpeg)
    except ValueError as error:
        cure = "leave this view out: name the others with --view"
        raise ExportError(f"{what} cannot be decoded ({error}); {cure}") from error
    return pixels
