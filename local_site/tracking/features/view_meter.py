"""One camera's part in tracking: frames in, features out, and the overlay of what was found."""

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from typing import Protocol

import cv2
import numpy as np

from common.cameras.camera import Frame, Image
from common.geometry import Array
from local_site.calibration.rig import CameraCalibration, Rig
from local_site.calibration.triangulation import project
from local_site.calibration.undistortion import Undistorter
from local_site.tracking.features.features import Features, measure
from local_site.tracking.features.medial import MedialLine
from local_site.tracking.features.posture import Posture
from local_site.tracking.features.silhouette import Silhouette, to_grey
from local_site.tracking.tracker import FrameCache, Overlay, View, Views

MIN_SIDE_PX = 32
LINE_SAMPLES = 200


class Foreground(Protocol):
    """Tells the arm from the rest of one camera's undistorted, smoothed grey pictures (H, W)."""

    def silhouette(self, grey: Image) -> Silhouette | str:
        """The arm, or a sentence with the reason why there is none."""

    def forget(self) -> None:
        """Forget what followed the pictures so far."""


class ViewMeter:
    """Measures the frames of one camera, in which a foreground shows the arm."""

    def __init__(self, camera: CameraCalibration, foreground: Foreground) -> None:
        self._camera, self._foreground = camera, foreground
        self._undistorter = Undistorter(camera.lens, cv2.BORDER_REPLICATE)
        self._frames = FrameCache(blend)

    def features(self, view: View, guess: Posture | None) -> Features | str:
        """The features at the view's instant, or a sentence with the reason why there are none."""
        found = self._frames.at(view, partial(self._measure, guess=guess))
        return f"{self._camera.name}: {found}" if isinstance(found, str) else found

    def forget(self) -> None:
        """Find the arm again with the next frame, as if it were the first."""
        self._foreground.forget()

    def overlay(self, view: Features, points: Sequence[Array]) -> Overlay:
        """The overlay of a view; points (3,) in m are elbow and wrist, and index and thumb where they are known."""
        return overlay_of(self._camera, view, points)

    def _measure(self, frame: Frame, guess: Posture | None) -> Features | str:
        problem = picture_problem(frame.image, self._camera)
        if problem:
            return problem
        grey = self._undistorter.undistorted(to_grey(frame.image))
        silhouette = self._foreground.silhouette(grey)
        return silhouette if isinstance(silhouette, str) else features_of(silhouette, guess)


def picture_problem(image: Image, camera: CameraCalibration) -> str:
    """Say why a picture cannot be one of this camera's; empty if it can."""
    is_picture = image.dtype == np.uint8 and image.ndim in (2, 3) and min(image.shape) > 0
    if not is_picture or min(image.shape[:2]) < MIN_SIDE_PX:
        return "the picture is too small or of a wrong kind"
    height, width = image.shape[:2]
    if camera.size_px in (None, (width, height)):
        return ""
    return "the picture is {}x{}, but was calibrated at {}x{}".format(width, height, *camera.size_px or ())


def views_problem(rig: Rig, views: Views, least: int) -> str:
    """Say why the pictures of an instant cannot be those of a rig with at least so many cameras; empty if they can."""
    if len(views.views) != len(rig.cameras):
        return f"{len(views.views)} views for {len(rig.cameras)} calibrated cameras"
    if len(views.views) < least:
        return f"this tracker needs {least} cameras at least; calibrate a rig of as many"
    problems = [
        f"{camera.name}: {problem}"
        for camera, view in zip(rig.cameras, views.views, strict=True)
        for frame in (view.current, view.previous or view.current)
        if (problem := picture_problem(frame.image, camera))
    ]
    return "; ".join(dict.fromkeys(problems))


def features_of(silhouette: Silhouette, guess: Posture | None) -> Features | str:
    """The features of a silhouette near a guess, or else found without one; a sentence if it shows none to be used."""
    features = measure(silhouette, guess)
    if features is None:
        return "no forearm can be made out; hold the arm bent and across the view"
    cropped = features.hand is not None and silhouette.touches_border(features.hand).any()
    return "the hand is cropped by the border" if cropped else features


def overlay_of(camera: CameraCalibration, view: Features, points: Sequence[Array]) -> Overlay:
    """Build what to draw over a view: outline and lines, and points (3,) in m: elbow, wrist, then index and thumb."""
    upper = view.upper_arm
    elbow, wrist, index, thumb, *_ = (*camera.distort_pixels(project(camera.matrix, np.array(points))), None, None)
    forearm_line = _seen_part(view.silhouette, view.forearm.at(0.0), view.guess.wrist)
    upper_line = None if upper is None else np.array([upper.at(0.0), view.guess.shoulder_end])
    return Overlay(
        contour=np.rint(camera.distort_pixels(view.silhouette.contour)).astype(np.int32),
        forearm_line=None if forearm_line is None else camera.distort_pixels(forearm_line),
        upper_arm_line=None if upper_line is None else camera.distort_pixels(upper_line),
        elbow=elbow,
        wrist=wrist,
        index=index,
        thumb=thumb,
    )


def _seen_part(silhouette: Silhouette, elbow: Array, wrist: Array) -> Array | None:
    """The ends (2, 2) of what the silhouette shows of the line between two pixels; None where it shows nothing."""
    line = np.linspace(elbow, wrist, LINE_SAMPLES)
    height, width = silhouette.grey.shape
    inside = np.flatnonzero(np.all((line >= 0) & (line <= (width - 1, height - 1)), axis=1))
    columns, rows = np.rint(line[inside]).astype(int).T
    seen = inside[silhouette.grey[rows, columns] > silhouette.level]
    return line[[seen[0], seen[-1]]] if len(seen) else None


def blend(before: Features, now: Features, weight: float) -> Features:
    """The features at a fraction `weight` of the time from one frame of a camera to its next.

    The hand's outline is that of the later frame, to be moved back with the hand.
    """

    def mix(a: Array, b: Array) -> Array:
        result: Array = (1 - weight) * a + weight * b
        return result

    def line(a: MedialLine, b: MedialLine) -> MedialLine:
        direction = mix(a.direction, b.direction)
        return MedialLine(mix(a.point, b.point), direction / max(float(np.linalg.norm(direction)), 1e-9))

    shift = np.zeros(2)
    if before.hand is not None and now.hand is not None:
        shift = (1 - weight) * (before.hand.mean(axis=0) - now.hand.mean(axis=0))
    pairs = zip(before.guess.points, now.guess.points, strict=True)
    shoulder_end, elbow, wrist, hand_end = (mix(a, b) for a, b in pairs)
    return replace(
        now,
        forearm=line(before.forearm, now.forearm),
        root=line(before.root, now.root),
        forearm_sides=mix(before.forearm_sides, now.forearm_sides),
        upper_arm=line(before.upper_arm, now.upper_arm) if before.upper_arm and now.upper_arm else None,
        upper_arm_sides=mix(before.upper_arm_sides, now.upper_arm_sides),
        wrist=None if before.wrist is None or now.wrist is None else mix(before.wrist, now.wrist),
        hand_shift=shift,
        guess=Posture(shoulder_end, elbow, wrist, hand_end, now.guess.half_width),
    )
