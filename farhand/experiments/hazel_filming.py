"""Renders the textured arm frame by frame and tracks it with the monocular tracker; keeps true and measured poses."""

from collections.abc import Iterable
from dataclasses import dataclass

import cv2
import msgspec

from common.cameras.camera import Frame, Image
from common.clock import NS_PER_S
from common.geometry import Array
from common.messages.hand import TrackingStatus
from farhand.experiments.filming import Progress
from local_site.simulation.hazel import TrueArm, film_camera, film_pixel
from local_site.simulation.textured_arm import ArmFilm, LimbPose
from local_site.tracking.config import MonocularConfig, StartConfig
from local_site.tracking.monocular.monocular_tracker import MonocularTracker
from local_site.tracking.monocular.pose import ArmPose
from local_site.tracking.tracker import View, Views

FPS = 30.0


@dataclass(frozen=True, slots=True)
class Footage:
    """Pictures of an arm, and the true arm in each, in the camera's frame."""

    pictures: tuple[Image, ...]
    true_arms: tuple[TrueArm, ...]


@dataclass(frozen=True, slots=True)
class Tracked:
    """For each frame the true arm, the tracked pose, both in the camera's frame (None where lost), and the status."""

    true_arms: tuple[TrueArm, ...]
    poses: tuple[ArmPose | None, ...]
    statuses: tuple[TrackingStatus, ...]


def render_footage(film: ArmFilm, arms: Iterable[TrueArm], with_finger: bool, progress: Progress) -> Footage:
    """Render one picture for each arm."""
    cv2.setNumThreads(1)
    pictures, true_arms = [], []
    for arm in arms:
        upper, forearm = arm.limb_poses()
        # The stretched finger moves rigidly with the forearm.
        limbs: tuple[LimbPose, ...] = (upper, forearm, forearm) if with_finger else (upper, forearm)
        pictures.append(film.render(limbs))
        true_arms.append(arm)
        progress()
    return Footage(tuple(pictures), tuple(true_arms))


def with_occluder(footage: Footage, box: tuple[int, int, int, int], frames: range, level: int) -> Footage:
    """A copy with a box (left, top, right, bottom; px) of a grey level (0 to 255) painted over the given frames."""
    left, top, right, bottom = box
    pictures = [picture.copy() for picture in footage.pictures]
    for picture in pictures[frames.start : frames.stop]:
        picture[top:bottom, left:right] = level
    return Footage(tuple(pictures), footage.true_arms)


def track_footage(footage: Footage, config: MonocularConfig, click_px: float) -> Tracked:
    """Track all pictures from the true joints in the first, rounded to multiples of `click_px` (0: not rounded)."""
    first = footage.true_arms[0]
    shoulder, elbow, wrist = (_click(p, click_px) for p in (first.shoulder, first.elbow, first.wrist))
    start = StartConfig(shoulder_px=shoulder, elbow_px=elbow, wrist_px=wrist)
    tracker = MonocularTracker(film_camera(), msgspec.structs.replace(config, start=start))
    poses, statuses = [], []
    for k, picture in enumerate(footage.pictures):
        t_ns = round(k * NS_PER_S / FPS)
        statuses.append(tracker.track(Views(t_ns, (View(Frame(picture, t_ns, k)),))).status)
        poses.append(tracker.pose)
    return Tracked(footage.true_arms, tuple(poses), tuple(statuses))


def _click(point: Array, click_px: float) -> tuple[float, float]:
    x, y = film_pixel(point)
    return (click_px * round(x / click_px), click_px * round(y / click_px)) if click_px else (x, y)
