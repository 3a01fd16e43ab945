"""A hand with three markers before two to four cameras, drawn as antialiased discs: any pose, any of them hidden."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from common.cameras.camera import Frame, Image
from common.geometry import Array, rotation_from_vector
from local_site.calibration.rig import CameraCalibration, Rig
from local_site.simulation.cameras import PinholeCamera, stereo_pair
from local_site.simulation.config import StereoConfig
from local_site.tracking.markers.marker_tracker import MarkerTracker
from local_site.tracking.markers.spots import Spots, find_spots
from local_site.tracking.tracker import ArmEstimate, View, Views
from tests.local_site.tracking.rendered_arm import rows_of

NAMES = ("wrist", "index", "thumb")
PERIOD_NS = 33_333_333
RADIUS_M = 0.011
# Wrist, index, thumb of a hand in its U shape.
HAND = np.array([[0.0, 0.0, 0.0], [-0.155, -0.02, 0.085], [-0.125, -0.03, 0.0]])
START = np.array([0.55, 0.45, 0.55])


def spots_in(picture: Image, threshold: float = 40.0) -> Spots:
    """The spots of a picture that has some."""
    found = find_spots(picture, threshold)
    assert isinstance(found, Spots), found
    return found


def four_cameras() -> tuple[PinholeCamera, ...]:
    outer, inner = stereo_pair(StereoConfig()), stereo_pair(StereoConfig(half_angle_deg=9.0, elevation_deg=30.0))
    return (*outer, *inner)


def rig_of(cameras: Sequence[PinholeCamera], rms_px: float = 0.3) -> Rig:
    calibrated = tuple(CameraCalibration(f"camera {k}", rows_of(c.projection), rms_px) for k, c in enumerate(cameras))
    return Rig(calibrated, (-10.0, -10.0, -10.0), (10.0, 10.0, 10.0), (0.0, 0.0, 0.0), "drawn")


def hand_at(
    offset: Sequence[float] | Array = (0.0, 0.0, 0.0),
    turn: Sequence[float] | Array = (0.0, 0.0, 0.0),
    shape: Array = HAND,
) -> Array:
    hand: Array = START + np.asarray(offset) + shape @ rotation_from_vector(np.asarray(turn, dtype=float)).T
    return hand


def moving_hand(k: float) -> Array:
    """A hand that travels and turns."""
    offset = (0.10 * np.sin(0.08 * k), 0.06 * np.sin(0.05 * k), 0.08 * np.sin(0.06 * k))
    return hand_at(offset, (0.0, 0.0, 0.4 * np.sin(0.05 * k)))


def draw(
    camera: PinholeCamera,
    points: Array,
    levels: Sequence[float] = (220.0,) * 3,
    noise: float = 0.0,
    seed: int = 0,
) -> Image:
    """A picture of markers (N, 3) m of these brightnesses; NaN points are hidden."""
    height, width = 480, 640
    image = np.full((height, width), 10.0)
    for point, level in zip(points, levels, strict=True):
        if not np.isfinite(point).all():
            continue
        in_camera = camera.to_camera(point)
        u, v = camera.pixels(in_camera)
        radius = camera.focal_px * RADIUS_M / in_camera[2]
        left, top = int(u - radius) - 2, int(v - radius) - 2
        size = int(2 * radius) + 6
        if left < 0 or top < 0 or left + size > width or top + size > height:
            continue
        rows, columns = np.mgrid[top : top + size, left : left + size]
        coverage = np.clip(radius + 0.5 - np.hypot(columns - u, rows - v), 0.0, 1.0)
        patch = image[top : top + size, left : left + size]
        np.maximum(patch, 10.0 + coverage * (level - 10.0), out=patch)
    if noise:
        image += noise * np.random.default_rng(seed).standard_normal(image.shape)
    picture: Image = np.clip(np.rint(image), 0, 255).astype(np.uint8)
    return picture


@dataclass
class Scene:
    """Cameras, the tracker before them, and the number of the instant."""

    cameras: tuple[PinholeCamera, ...] = field(default_factory=lambda: four_cameras()[:2])
    tracker: MarkerTracker | None = None
    k: int = 0

    def __post_init__(self) -> None:
        self.tracker = self.tracker or MarkerTracker(rig_of(self.cameras))

    def step(self, points: Array, per_view: Mapping[int, Array] | None = None, **drawing: Any) -> ArmEstimate:
        """Track one instant; `per_view` gives other points (N, 3) for some cameras."""
        t_ns = self.k * PERIOD_NS
        frames = [
            Frame(draw(camera, (per_view or {}).get(i, points), **drawing), t_ns, self.k)
            for i, camera in enumerate(self.cameras)
        ]
        self.k += 1
        assert self.tracker is not None
        return self.tracker.track(Views(t_ns, tuple(View(frame) for frame in frames)))

    def learn(self, points: Array | None = None, **drawing: Any) -> list[ArmEstimate]:
        """The instants in which the tracker learns the hand."""
        return [self.step(hand_at() if points is None else points, **drawing) for _ in range(10)]


def error_mm(estimate: ArmEstimate, points: Array) -> Array:
    """The distance of every marker (3,) in mm, NaN where it is not given."""
    found = [getattr(estimate, name) for name in NAMES]
    return np.array([np.nan if p is None else 1e3 * np.linalg.norm(p - q) for p, q in zip(found, points, strict=True)])


def without(points: Array, *names: str) -> Array:
    """The points with some markers hidden."""
    hidden = np.array([name in names for name in NAMES])
    return np.where(hidden[:, None], np.nan, points)
