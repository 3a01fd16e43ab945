"""Films of the textured arm, and what the monocular tracker makes of them: true and measured, frame by frame."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from common.cameras.camera import Frame, Image
from common.clock import NS_PER_S
from common.errors import InterruptionError
from common.geometry import Array
from common.messages.hand import TrackingStatus
from local_site.simulation.hazel import TrueArm, film_camera, film_pixel
from local_site.simulation.textured_arm import ArmFilm, Place
from local_site.tracking.config import MonocularConfig, StartConfig
from local_site.tracking.monocular.monocular_tracker import MonocularTracker
from local_site.tracking.monocular.pose import ArmPose
from local_site.tracking.tracker import View, Views

FPS = 30.0

Progress = Callable[[], bool]


@dataclass(frozen=True, slots=True)
class Footage:
    """Pictures of an arm, and the arm as it truly was in each."""

    pictures: tuple[Image, ...]
    arms: tuple[TrueArm, ...]


@dataclass(frozen=True, slots=True)
class Tracked:
    """What the tracker said of each frame: its status, and the pose in the camera's frame where it gave one."""

    arms: tuple[TrueArm, ...]
    poses: tuple[ArmPose | None, ...]
    statuses: tuple[TrackingStatus, ...]


def shoot(film: ArmFilm, arms: Iterable[TrueArm], with_finger: bool, progress: Progress) -> Footage:
    """Render all arms; `progress` is called after each, and when it says False, InterruptionError."""
    cv2.setNumThreads(1)
    pictures, shown = [], []
    for arm in arms:
        upper, forearm = arm.places()
        places: tuple[Place, ...] = (upper, forearm, forearm) if with_finger else (upper, forearm)
        pictures.append(film.render(places))
        shown.append(arm)
        if not progress():
            raise InterruptionError("interrupted before the experiment was done; nothing was written")
    return Footage(tuple(pictures), tuple(shown))


def occluded(footage: Footage, box: tuple[int, int, int, int], frames: range, level: int) -> Footage:
    """The same with a grey box (left, top, right, bottom) before the arm in some frames."""
    left, top, right, bottom = box
    pictures = [picture.copy() for picture in footage.pictures]
    for k in frames:
        if k < len(pictures):
            pictures[k][top:bottom, left:right] = level
    return Footage(tuple(pictures), footage.arms)


def watch(footage: Footage, config: MonocularConfig, click_px: float) -> Tracked:
    """Track all pictures; the joints in the first are clicked to the nearest multiple of `click_px`."""
    first = footage.arms[0]
    shoulder, elbow, wrist = (_clicked(p, click_px) for p in (first.shoulder, first.elbow, first.wrist))
    start = StartConfig(shoulder_px=shoulder, elbow_px=elbow, wrist_px=wrist)
    tracker = MonocularTracker(film_camera(), _started(config, start))
    poses, statuses = [], []
    for k, picture in enumerate(footage.pictures):
        t_ns = round(k * NS_PER_S / FPS)
        statuses.append(tracker.track(Views(t_ns, (View(Frame(picture, t_ns, k)),))).status)
        poses.append(tracker.pose)
    return Tracked(footage.arms, tuple(poses), tuple(statuses))


def joints(arms: Sequence[TrueArm] | Sequence[ArmPose | None], name: str, along_forearm_m: float) -> Array:
    """A joint by its name, or a point so far along the forearm where the name is none, (N, 3) in m; NaN where lost."""
    return np.array([_joint(arm, name, along_forearm_m) for arm in arms])


def _joint(arm: TrueArm | ArmPose | None, name: str, along_forearm_m: float) -> Array:
    if arm is None:
        return np.full(3, np.nan)
    joint: Array = {"shoulder": arm.shoulder, "elbow": arm.elbow}.get(
        name, arm.elbow + along_forearm_m * arm.forearm[:, 2]
    )
    return joint


def _clicked(point: Array, click_px: float) -> tuple[float, float]:
    x, y = film_pixel(point)
    return (click_px * round(x / click_px), click_px * round(y / click_px)) if click_px else (x, y)


def _started(config: MonocularConfig, start: StartConfig) -> MonocularConfig:
    return MonocularConfig(
        setting=config.setting, upper_arm=config.upper_arm, forearm=config.forearm, noise=config.noise, start=start
    )
