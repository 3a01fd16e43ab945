"""What a preview needs of an estimate, as bytes for the process that draws it, and the drawing itself."""

from collections.abc import Sequence

import cv2
import msgspec
import numpy as np
import simplejpeg

from common.cameras.camera import Image
from common.geometry import Array
from common.messages.hand import TrackingStatus
from local_site.preview.config import PreviewConfig
from local_site.tracking.annotate import annotate
from local_site.tracking.tracker import ArmEstimate, Overlay, Views

POINTS = ("elbow", "wrist", "index", "thumb")
LINES = ("forearm_line", "upper_arm_line")

Numbers = tuple[float, ...]


class Marks(msgspec.Struct, frozen=True):
    """An overlay in plain numbers; `contour` is the bytes of int32 pairs."""

    contour: bytes | None
    lines: dict[str, Numbers]
    points: dict[str, Numbers]


class PictureInfo(msgspec.Struct, frozen=True):
    """What is known of a picture beside its pixels."""

    shape: tuple[int, ...]
    capture_ns: int
    capture_estimated: bool


class DrawingOrder(msgspec.Struct, frozen=True):
    """Everything to be drawn at one instant, without the pictures."""

    taken: tuple[PictureInfo, ...]
    status: TrackingStatus
    reason: str
    thumb_inferred: bool
    places: dict[str, Numbers]
    covariances: dict[str, Numbers]
    marks: tuple[Marks, ...]


class Drawn(msgspec.Struct, frozen=True):
    """One view, ready to be sent."""

    taken: PictureInfo
    width: int
    height: int
    jpeg: bytes


def order_of(views: Views, estimate: ArmEstimate) -> DrawingOrder:
    """What to draw for an instant."""
    frames = [view.current for view in views.views]
    return DrawingOrder(
        taken=tuple(PictureInfo(f.image.shape, f.capture_ns, f.capture_estimated) for f in frames),
        status=estimate.status,
        reason=estimate.reason,
        thumb_inferred=estimate.thumb_inferred,
        places=_known(estimate, POINTS),
        covariances={name: _numbers(matrix) for name, matrix in estimate.covariances.items()},
        marks=tuple(_marks(overlay) for overlay in estimate.overlays),
    )


def estimate_of(order: DrawingOrder) -> ArmEstimate:
    """The estimate again, as far as it is drawn."""
    places = {name: np.array(numbers) for name, numbers in order.places.items()}
    return ArmEstimate(
        t_ns=0,
        status=order.status,
        reason=order.reason,
        thumb_inferred=order.thumb_inferred,
        overlays=tuple(_overlay(marks) for marks in order.marks),
        covariances={name: np.array(numbers).reshape(3, 3) for name, numbers in order.covariances.items()},
        elbow=places.get("elbow"),
        wrist=places.get("wrist"),
        index=places.get("index"),
        thumb=places.get("thumb"),
    )


def draw(
    order: DrawingOrder, pictures: Sequence[Image], projections: Sequence[Array], config: PreviewConfig
) -> list[Drawn]:
    """All views of an instant with what was found in them; the pictures are flat, as they came through the memory."""
    estimate = estimate_of(order)
    return [
        _drawn(annotate(pixels.reshape(taken.shape), estimate, k, projections[k]), taken, config)
        for k, (pixels, taken) in enumerate(zip(pictures, order.taken, strict=True))
    ]


def _drawn(picture: Image, taken: PictureInfo, config: PreviewConfig) -> Drawn:
    height, width = picture.shape[:2]
    if width > config.width:
        size = config.width, round(height * config.width / width)
        picture = np.asarray(cv2.resize(picture, size, interpolation=cv2.INTER_AREA), dtype=np.uint8)
        width, height = size
    return Drawn(taken, width, height, bytes(simplejpeg.encode_jpeg(picture, config.quality, "BGR", "420")))


def _marks(overlay: Overlay) -> Marks:
    contour = None if overlay.contour is None else overlay.contour.astype(np.int32).tobytes()
    return Marks(contour, _known(overlay, LINES), _known(overlay, POINTS))


def _overlay(marks: Marks) -> Overlay:
    return Overlay(
        contour=None if marks.contour is None else np.frombuffer(marks.contour, np.int32).reshape(-1, 2),
        **{name: np.array(numbers).reshape(2, 2) for name, numbers in marks.lines.items()},
        **{name: np.array(numbers) for name, numbers in marks.points.items()},
    )


def _known(found: ArmEstimate | Overlay, names: Sequence[str]) -> dict[str, Numbers]:
    return {name: _numbers(array) for name in names if (array := getattr(found, name)) is not None}


def _numbers(array: Array) -> Numbers:
    return tuple(array.ravel().tolist())
