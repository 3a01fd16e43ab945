"""Judgement of a room for tracking: light, contrast of the arm to what is behind it, the elbow in both views."""

from collections.abc import Mapping
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from common.cameras.camera import Image
from common.geometry import Array
from farhand.doctor.findings import Finding, ok, warning
from local_site.kernels.pictures import as_grey

SATURATED = 250
MIN_BRIGHT, MAX_SATURATED = 90.0, 0.02
MIN_CONTRAST = 40.0
EDGE_PX, RING_PX = 5, 25
MIN_ELBOW_SHARE = 0.9

DIM = "more light on the arm, or a longer exposure (exposure_ms in [operator.cameras]), or more gain"
GLARE = "less light on the arm, or a shorter exposure (exposure_ms in [operator.cameras]), or less gain"
PALE = "a darker and plainer background, a dark cloth for one, and more light on the arm than behind it"
ELBOW = (
    "turn the cameras, or move them away, until elbow and hand are in both pictures; roll the sleeve up above the elbow"
)


@dataclass(frozen=True, slots=True)
class Light:
    """The light on a picture or a part of it: mean grey level, that of its brightest parts, the saturated fraction."""

    mean: float
    bright: float
    saturated: float


def light_of(greys: NDArray[np.uint8]) -> Light:
    """The light of grey levels of any shape, at least one of them."""
    return Light(float(greys.mean()), float(np.percentile(greys, 95)), float(np.mean(greys >= SATURATED)))


@dataclass(frozen=True, slots=True)
class ArmInPicture:
    """The arm in a picture: its own light, and the mean grey level of a ring around it."""

    light: Light
    around: float

    @property
    def contrast(self) -> float:
        """The arm's brightness above that of the ring around it, grey levels."""
        return self.light.mean - self.around


def arm_in_picture(picture: Image, contour: NDArray[np.int32]) -> ArmInPicture | None:
    """The arm within an outline (N, 2) in px, less its edge, and the ring around it; None if nothing of one is left."""
    grey = as_grey(picture)
    arm = np.zeros(grey.shape, dtype=np.uint8)
    cv2.fillPoly(arm, [contour.reshape(-1, 1, 2)], 255)
    inner = cv2.erode(arm, _disc(EDGE_PX)) > 0
    ring = (cv2.dilate(arm, _disc(RING_PX)) > 0) & (cv2.dilate(arm, _disc(EDGE_PX)) == 0)
    if not inner.any() or not ring.any():
        return None
    return ArmInPicture(light_of(grey[inner]), float(grey[ring].mean()))


def _disc(radius: int) -> NDArray[np.uint8]:
    return np.asarray(cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * radius + 1,) * 2), dtype=np.uint8)


def in_view(pixel: Array, size: tuple[int, int], margin: float = 0.02) -> bool:
    """Return whether a pixel (2,) is inside a picture of this size (width, height), off its edges by a part of it."""
    return all(margin * extent <= value <= (1 - margin) * extent for value, extent in zip(pixel, size, strict=True))


def judge_light(name: str, light: Light, where: str) -> Finding:
    """Judge whether the light in a view is right; `where` says of what."""
    sentence = f"{where}: mean level {light.mean:.0f} of 255, {100 * light.saturated:.1f} % saturated"
    if light.bright < MIN_BRIGHT:
        return warning(f"light {name}", f"{sentence}, which is dark", DIM)
    if light.saturated > MAX_SATURATED:
        return warning(f"light {name}", f"{sentence}, which is too bright", GLARE)
    return ok(f"light {name}", sentence)


def judge_background(name: str, light: Light) -> Finding:
    """Judge whether anything stands out where no arm was found, for a tracker that needs a dark background."""
    sentence = f"no arm found, and the brightest parts are {light.bright - light.mean:.0f} levels above the mean"
    if light.bright - light.mean < MIN_CONTRAST:
        return warning(f"contrast {name}", f"{sentence}, needs {MIN_CONTRAST:.0f}", PALE)
    return ok(f"contrast {name}", sentence)


def judge_contrast(name: str, contrast: float, needs_dark: bool) -> Finding:
    """Judge whether the arm stands out in a view; `needs_dark` is whether the tracker needs a dark background."""
    sentence = f"the arm is {contrast:.0f} levels brighter than what is around it"
    if needs_dark and contrast < MIN_CONTRAST:
        return warning(f"contrast {name}", f"{sentence}, needs {MIN_CONTRAST:.0f}", PALE)
    return ok(f"contrast {name}", sentence)


def judge_elbow(shares: Mapping[str, float]) -> Finding:
    """Judge whether the elbow is in all views; `shares`: in which fraction of the instants with one a view shows it."""
    sentence = ", ".join(f"{name} {100 * share:.0f} %" for name, share in shares.items()) or "never found"
    if not shares or min(shares.values()) < MIN_ELBOW_SHARE:
        return warning("elbow in view", sentence, ELBOW)
    return ok("elbow in view", sentence)
