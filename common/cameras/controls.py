"""Sets a camera through OpenCV, reads back what it really does, and says where that differs from what was asked."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Protocol

import cv2

from common.cameras.camera import Image
from common.cameras.modes import describe_modes, device_of
from common.cameras.settings import Auto, CameraSettings
from common.errors import CameraError

V4L2 = "V4L2"
CURE = ". Cure: "  # ends what is wrong in an error's text
# V4L2_CID_EXPOSURE_AUTO is a menu. In mode 2 the driver chooses the iris alone, so the time is fixed as in mode 1.
AUTOMATIC, MANUAL, APERTURE_PRIORITY = 0, 1, 3
EXPOSURE_UNIT_MS = 0.1  # of V4L2_CID_EXPOSURE_ABSOLUTE
RATE_TOLERANCE = 0.02  # 29.97 counts as 30
EXPOSURE_TOLERANCE = 0.1


class VideoCapture(Protocol):
    """The part of cv2.VideoCapture that is used."""

    def isOpened(self) -> bool: ...

    def getBackendName(self) -> str: ...

    def get(self, propId: int, /) -> float: ...

    def set(self, propId: int, value: float, /) -> bool: ...

    def grab(self) -> bool: ...

    def read(self) -> tuple[bool, object]: ...

    def release(self) -> None: ...


@dataclass(frozen=True, slots=True)
class CameraState:
    """The settings in force at a camera; None where it does not report one. Units as in CameraSettings."""

    size_px: tuple[int, int]
    fps: float | None = None
    pixel_format: str | None = None
    exposure_ms: float | Auto | None = None
    gain: int | None = None
    focus: int | Auto | None = None

    def __str__(self) -> str:
        named = (("exposure {}", _in_ms(self.exposure_ms)), ("gain {}", self.gain), ("focus {}", self.focus))
        parts = [f"{self.size_px[0]} x {self.size_px[1]}"]
        parts += [self.pixel_format] if self.pixel_format else []
        parts += [f"{self.fps:g} fps"] if self.fps else []
        parts += [text.format(value) for text, value in named if value is not None]
        return ", ".join(parts)


def set_up(capture: VideoCapture, settings: CameraSettings, wished_fps: float | None) -> None:
    """Ask for everything that is given; `wished_fps` is asked for where the settings have no rate."""
    # Format before size, as a size may exist in one format only; the rate last, as OpenCV sets it anew with the others.
    if settings.pixel_format is not None:
        capture.set(cv2.CAP_PROP_FOURCC, cv2.VideoWriter.fourcc(*settings.pixel_format))
    if settings.size_px is not None:
        capture.set(cv2.CAP_PROP_FRAME_WIDTH, settings.size_px[0])
        capture.set(cv2.CAP_PROP_FRAME_HEIGHT, settings.size_px[1])
    capture.set(cv2.CAP_PROP_BUFFERSIZE, 1)
    fps = wished_fps if settings.fps is None else settings.fps
    if fps is not None:
        capture.set(cv2.CAP_PROP_FPS, fps)
    if capture.getBackendName() == V4L2:
        _set_controls(capture, settings)


def _set_controls(capture: VideoCapture, settings: CameraSettings) -> None:
    if settings.exposure_ms == "auto":
        if not capture.set(cv2.CAP_PROP_AUTO_EXPOSURE, APERTURE_PRIORITY):
            capture.set(cv2.CAP_PROP_AUTO_EXPOSURE, AUTOMATIC)
    elif settings.exposure_ms is not None:
        capture.set(cv2.CAP_PROP_AUTO_EXPOSURE, MANUAL)
        capture.set(cv2.CAP_PROP_EXPOSURE, max(1, round(settings.exposure_ms / EXPOSURE_UNIT_MS)))
    if settings.gain is not None:
        capture.set(cv2.CAP_PROP_GAIN, settings.gain)
    if settings.focus is not None:
        capture.set(cv2.CAP_PROP_AUTOFOCUS, settings.focus == "auto")
    if isinstance(settings.focus, int):
        capture.set(cv2.CAP_PROP_FOCUS, settings.focus)


def read_back(capture: VideoCapture, image: Image) -> CameraState:
    """Read a camera's settings back from its driver and from a picture of it (height, width[, 3])."""
    height, width = image.shape[:2]
    fps = capture.get(cv2.CAP_PROP_FPS)
    state = CameraState((width, height), fps if math.isfinite(fps) and fps > 0 else None, _pixel_format(capture))
    if capture.getBackendName() != V4L2:
        return state
    gain, focus = capture.get(cv2.CAP_PROP_GAIN), capture.get(cv2.CAP_PROP_FOCUS)
    return CameraState(
        state.size_px,
        state.fps,
        state.pixel_format,
        _exposure_ms(capture),
        gain=None if gain < 0 else round(gain),
        focus="auto" if capture.get(cv2.CAP_PROP_AUTOFOCUS) > 0 else None if focus < 0 else round(focus),
    )


def _pixel_format(capture: VideoCapture) -> str | None:
    code = int(capture.get(cv2.CAP_PROP_FOURCC))
    text = "".join(chr((code >> 8 * k) & 0xFF) for k in range(4)) if code > 0 else ""
    return text if text.isprintable() and text else None


def _exposure_ms(capture: VideoCapture) -> float | Auto | None:
    if capture.get(cv2.CAP_PROP_AUTO_EXPOSURE) in (AUTOMATIC, APERTURE_PRIORITY):
        return "auto"
    exposure = capture.get(cv2.CAP_PROP_EXPOSURE)
    return None if exposure < 0 else round(exposure * EXPOSURE_UNIT_MS, 3)


def check_state(name: str, source: str, settings: CameraSettings, state: CameraState) -> None:
    """CameraError with all that the camera does otherwise than its settings ask, and the cure."""
    modes, controls = list(_other_modes(settings, state)), list(_other_controls(settings, state))
    if not modes and not controls:
        return
    device, cures = device_of(source), []
    if device is None:
        cures.append("set it in the camera's own configuration, or leave these keys out")
    if device is not None and modes:
        cures.append(describe_modes(device))
    if device is not None and controls:
        cures.append(
            f"see what can be set, and in which steps, with: v4l2-ctl -d {device} --list-ctrls, or leave these keys out"
        )
    raise CameraError(f"camera {name}: {source} {'; '.join(modes + controls)}{CURE}{'; '.join(cures)}")


def _other_modes(settings: CameraSettings, state: CameraState) -> Iterator[str]:
    if settings.size_px not in (None, state.size_px):
        asked, is_now = (f"{width} x {height}" for width, height in (settings.size_px or (0, 0), state.size_px))
        yield f"gives pictures of {is_now}, asked were {asked}"
    if settings.pixel_format not in (None, state.pixel_format):
        yield f"gives the pixel format {state.pixel_format or 'unknown'}, asked was {settings.pixel_format}"
    if settings.fps is not None and not math.isclose(settings.fps, state.fps or 0.0, rel_tol=RATE_TOLERANCE):
        yield f"gives {f'{state.fps:g}' if state.fps else 'an unknown number of'} fps, asked were {settings.fps:g}"


def _other_controls(settings: CameraSettings, state: CameraState) -> Iterator[str]:
    if not _same_exposure(settings.exposure_ms, state.exposure_ms):
        yield _otherwise("an exposure", _in_ms(state.exposure_ms), _in_ms(settings.exposure_ms))
    if settings.gain not in (None, state.gain):
        yield _otherwise("a gain", state.gain, settings.gain)
    if settings.focus not in (None, state.focus):
        yield _otherwise("a focus", state.focus, settings.focus)


def _same_exposure(asked: float | Auto | None, is_now: float | Auto | None) -> bool:
    if isinstance(asked, float | int) and isinstance(is_now, float | int):
        return math.isclose(asked, is_now, rel_tol=EXPOSURE_TOLERANCE, abs_tol=EXPOSURE_UNIT_MS)
    return asked is None or asked == is_now


def _otherwise(what: str, is_now: int | str | None, asked: int | str | None) -> str:
    if is_now is None:
        return f"does not let {what} be set, asked was {asked}"
    return f"has {what} of {is_now}, asked was {asked}"


def _in_ms(exposure: float | Auto | None) -> str | None:
    return f"{exposure:g} ms" if isinstance(exposure, float | int) else exposure
