"""Films of the textured arm, and what the monocular tracker makes of them: true and measured, frame by frame."""

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
from local_site.simulation.textured_arm import ArmFilm, Place
from local_site.tracking.monocular.config import MonocularConfig, StartConfig
from local_site.tracking.monocular.monocular_tracker import MonocularTracker
from local_site.tracking.monocular.pose import ArmPose
from local_site.tracking.tracker import View, Views

FPS = 30.0


@dataclass(frozen=True, slots=True)
class Footage:
    """Pictures of an arm, and the arm as it truly was in each."""

    pictures: tuple[Image, ...]
    arms: tuple[TrueArm, ...]


@dataclass(frozen=True, slots=True)
class Tracked:
    """The tracker's result for each frame: its status, and the pose in the camera's frame, None where it was lost."""

    arms: tuple[TrueArm, ...]
    poses: tuple[ArmPose | None, ...]
    statuses: tuple[TrackingStatus, ...]


def shoot(film: ArmFilm, arms: Iterable[TrueArm], with_finger: bool, progress: Progress) -> Footage:
    """Render all arms."""
    cv2.setNumThreads(1)
    pictures, shown = [], []
    for arm in arms:
        upper, forearm = arm.places()
        places: tuple[Place, ...] = (upper, forearm, forearm) if with_finger else (upper, forearm)
        pictures.append(film.render(places))
        shown.append(arm)
        progress()
    return Footage(tuple(pictures), tuple(shown))


def occluded(footage: Footage, box: tuple[int, int, int, int], frames: range, level: int) -> Footage:
    """The same with a box (left, top, right, bottom; px) of a grey level in front of the arm in some frames."""
    left, top, right, bottom = box
    pictures = [picture.copy() for picture in footage.pictures]
    for picture in pictures[frames.start : frames.stop]:
        picture[top:bottom, left:right] = level
    return Footage(tuple(pictures), footage.arms)


def watch(footage: Footage, config: MonocularConfig, click_px: float) -> Tracked:
    """Track all pictures; the joints in the first are clicked to the nearest multiple of `click_px`, 0 exactly."""
    first = footage.arms[0]
    shoulder, elbow, wrist = (_clicked(p, click_px) for p in (first.shoulder, first.elbow, first.wrist))
    start = StartConfig(shoulder_px=shoulder, elbow_px=elbow, wrist_px=wrist)
    tracker = MonocularTracker(film_camera(), msgspec.structs.replace(config, start=start))
    poses, statuses = [], []
    for k, picture in enumerate(footage.pictures):
        t_ns = round(k * NS_PER_S / FPS)
        statuses.append(tracker.track(Views(t_ns, (View(Frame(picture, t_ns, k)),))).status)
        poses.append(tracker.pose)
    return Tracked(footage.arms, tuple(poses), tuple(statuses))


def _clicked(point: Array, click_px: float) -> tuple[float, float]:
    x, y = film_pixel(point)
    return (click_px * round(x / click_px), click_px * round(y / click_px)) if click_px else (x, y)
