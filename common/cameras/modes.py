"""The modes that a camera offers (pixel format, size, rates), as v4l2-ctl lists them."""

import re
import shutil
import subprocess
from dataclasses import dataclass

PROGRAM = "v4l2-ctl"
PATIENCE_S = 5.0
MOST_NAMED = 12

FORMAT_LINE = re.compile(r"\[\d+\]:\s*'(.{4})'")
SIZE_LINE = re.compile(r"Size:\s*Discrete\s+(\d+)x(\d+)")
RATE = re.compile(r"\(([\d.]+)\s*fps\)")


@dataclass(frozen=True, slots=True)
class CameraMode:
    """A pixel format (four-character code) and a size in pixels, with the rates (Hz) that the camera offers there."""

    pixel_format: str
    width_px: int
    height_px: int
    fps: tuple[float, ...]

    def __str__(self) -> str:
        rates = "/".join(f"{rate:g}" for rate in self.fps)
        return f"{self.pixel_format} {self.width_px} x {self.height_px}{f' at {rates} fps' if rates else ''}"


def device_of(source: str) -> str | None:
    """Return the device file of a source, a number or a path; None for a stream."""
    if source.isdecimal():
        return f"/dev/video{source}"
    return source if source.startswith("/dev/") else None


def list_modes(device: str) -> tuple[CameraMode, ...]:
    """List all modes of a device file; none where v4l2-ctl is not installed, or does not know the device."""
    program = shutil.which(PROGRAM)
    if program is None:
        return ()
    command = [program, "--device", device, "--list-formats-ext"]
    try:
        ended = subprocess.run(command, capture_output=True, text=True, timeout=PATIENCE_S, check=False)  # noqa: S603  # a system's own program
    except (OSError, subprocess.TimeoutExpired):
        return ()
    return parse_modes(ended.stdout)


def parse_modes(listing: str) -> tuple[CameraMode, ...]:
    """Read the modes with discrete sizes from the output of `v4l2-ctl --list-formats-ext`, in its order."""
    modes: list[CameraMode] = []
    pixel_format = ""
    for line in listing.splitlines():
        if found := FORMAT_LINE.search(line):
            pixel_format = found[1]
        elif found := SIZE_LINE.search(line):
            modes.append(CameraMode(pixel_format, int(found[1]), int(found[2]), ()))
        elif (found := RATE.search(line)) and modes:
            last = modes.pop()
            modes.append(CameraMode(last.pixel_format, last.width_px, last.height_px, (*last.fps, float(found[1]))))
    return tuple(modes)


def describe_modes(device: str) -> str:
    """Describe the modes that a device offers; without v4l2-ctl, say how to list them."""
    modes = list_modes(device)
    if not modes:
        return f"see what it offers with: {PROGRAM} -d {device} --list-formats-ext (Debian: apt-get install v4l-utils)"
    more = f", and {len(modes) - MOST_NAMED} more" if len(modes) > MOST_NAMED else ""
    return f"choose one of what it offers: {', '.join(map(str, modes[:MOST_NAMED]))}{more}"
