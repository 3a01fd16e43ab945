"""Draws the operator's views with what was found in them; the drawing order is encoded for the process that draws."""

from collections.abc import Sequence
from typing import Annotated

import cv2
import msgspec
import numpy as np
import simplejpeg
from msgspec import Meta

from common.cameras.camera import Image
from common.geometry import Array
from local_site.tracking.annotate import annotate
from local_site.tracking.tracker import ArmEstimate, Views


class PreviewConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Pictures of the operator with what was found in them; made only while a console shows them."""

    fps: Annotated[float, Meta(gt=0, le=60, description="pictures per second of each view, at most")] = 12.0
    width: Annotated[int, Meta(ge=160, le=3840, description="pixels; a narrower view stays as it is")] = 640
    quality: Annotated[int, Meta(ge=10, le=100, description="JPEG quality")] = 70


class PictureInfo(msgspec.Struct, frozen=True):
    """The metadata of a picture."""

    shape: tuple[int, ...]
    capture_ns: int
    capture_estimated: bool


class DrawingOrder(msgspec.Struct, frozen=True):
    """Everything to be drawn at one instant, without the pictures."""

    taken: tuple[PictureInfo, ...]
    estimate: ArmEstimate


class Drawn(msgspec.Struct, frozen=True):
    """One view, ready to be sent."""

    taken: PictureInfo
    width: int
    height: int
    jpeg: bytes


def encode_order(views: Views, estimate: ArmEstimate) -> bytes:
    """What to draw for an instant."""
    frames = [view.current for view in views.views]
    taken = tuple(PictureInfo(f.image.shape, f.capture_ns, f.capture_estimated) for f in frames)
    return msgspec.msgpack.encode(DrawingOrder(taken, estimate), enc_hook=_from_array)


def decode_order(data: bytes) -> DrawingOrder:
    """The order that was encoded."""
    return msgspec.msgpack.decode(data, type=DrawingOrder, dec_hook=_to_array)


def draw(
    order: DrawingOrder, pictures: Sequence[Image], projections: Sequence[Array], config: PreviewConfig
) -> list[Drawn]:
    """All views of an instant with what was found in them; the pictures are flat, as they came through the memory."""
    return [
        _drawn(annotate(pixels.reshape(taken.shape), order.estimate, k, projections[k]), taken, config)
        for k, (pixels, taken) in enumerate(zip(pictures, order.taken, strict=True))
    ]


def _drawn(picture: Image, taken: PictureInfo, config: PreviewConfig) -> Drawn:
    height, width = picture.shape[:2]
    if width > config.width:
        size = config.width, round(height * config.width / width)
        picture = np.asarray(cv2.resize(picture, size, interpolation=cv2.INTER_AREA), dtype=np.uint8)
        width, height = size
    return Drawn(taken, width, height, bytes(simplejpeg.encode_jpeg(picture, config.quality, "BGR", "420")))


def _from_array(value: object) -> object:
    """An array as dtype, shape and bytes; a NumPy scalar as a number."""
    if isinstance(value, np.ndarray):
        return value.dtype.str, value.shape, value.tobytes()
    if isinstance(value, np.generic):
        return value.item()
    raise NotImplementedError(f"a preview cannot carry {type(value)}")


def _to_array(_kind: type, parts: tuple[str, Sequence[int], bytes]) -> object:
    dtype, shape, data = parts
    return np.frombuffer(data, dtype).reshape(shape)
