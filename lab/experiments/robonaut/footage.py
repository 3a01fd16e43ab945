"""The textured arm filmed and tracked by one camera: its pictures, the true arm and the tracked one in each."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import cv2
import msgspec

from common.cameras.camera import Frame, Image
from common.clock import NS_PER_S
from lab.experiments.report import Progress
from local_site.simulation.hazel import FRAMES_PER_S, TrueArm, film_camera, film_pixel
from local_site.simulation.textured_arm import ArmFilm, LimbPose
from local_site.tracking.config import MonocularConfig, StartConfig
from local_site.tracking.monocular.arm_model import ArmPose
from local_site.tracking.monocular.monocular_tracker import MonocularTracker
from local_site.tracking.tracker import ArmEstimate, View, Views


@dataclass(frozen=True, slots=True)
class Shot:
    """The contents of one picture: the true arm in the camera's frame, and the poses of all limbs of the film."""

    arm: TrueArm
    limbs: Sequence[LimbPose]


@dataclass(frozen=True, slots=True)
class Footage:
    """Pictures of an arm, and the true arm in each, in the camera's frame."""

    pictures: tuple[Image, ...]
    true_arms: tuple[TrueArm, ...]


@dataclass(frozen=True, slots=True)
class Tracked:
    """For each frame the true arm, the tracked pose, both in the camera's frame (None where lost), and the estimate.

    The estimates are in the operator's frame, which is the camera's.
    """

    true_arms: tuple[TrueArm, ...]
    poses: tuple[ArmPose | None, ...]
    estimates: tuple[ArmEstimate, ...]

    def cut(self, frames: slice) -> "Tracked":
        """Some of the frames."""
        return Tracked(self.true_arms[frames], self.poses[frames], self.estimates[frames])


def bare(arm: TrueArm) -> Shot:
    """The arm and nothing else."""
    return Shot(arm, arm.limb_poses())


def render_footage(film: ArmFilm, shots: Iterable[Shot], progress: Progress) -> Footage:
    """Render one picture for each shot."""
    cv2.setNumThreads(1)
    pictures, true_arms = [], []
    for shot in shots:
        pictures.append(film.render(shot.limbs))
        true_arms.append(shot.arm)
        progress()
    return Footage(tuple(pictures), tuple(true_arms))


def with_occluder(footage: Footage, box: tuple[int, int, int, int], frames: range, level: int) -> Footage:
    """A copy with a box (left, top, right, bottom; px) of a grey level (0 to 255) painted over the given frames."""
    left, top, right, bottom = box
    pictures = [picture.copy() for picture in footage.pictures]
    for picture in pictures[frames.start : frames.stop]:
        picture[top:bottom, left:right] = level
    return Footage(tuple(pictures), footage.true_arms)


def frame_ns(frame: int) -> int:
    """Return when a frame of these films is exposed, ns since the first."""
    return round(frame * NS_PER_S / FRAMES_PER_S)


def track_footage(footage: Footage, config: MonocularConfig, click_px: float) -> Tracked:
    """Track all pictures from the true joints in the first, rounded to multiples of `click_px` (0: not rounded)."""
    first = footage.true_arms[0]
    joints = [film_pixel(point) for point in (first.shoulder, first.elbow, first.wrist)]
    if click_px:
        joints = [(click_px * round(x / click_px), click_px * round(y / click_px)) for x, y in joints]
    start = StartConfig(shoulder_px=joints[0], elbow_px=joints[1], wrist_px=joints[2])
    tracker = MonocularTracker(film_camera(), msgspec.structs.replace(config, start=start))
    poses, estimates = [], []
    for k, picture in enumerate(footage.pictures):
        t_ns = frame_ns(k)
        estimates.append(tracker.track(Views(t_ns, (View(Frame(picture, t_ns, k)),))))
        poses.append(tracker.pose)
    return Tracked(footage.true_arms, tuple(poses), tuple(estimates))
