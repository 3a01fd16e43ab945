"""A trial of the configured tracker: how much of it tracks, why the rest does not, and what the room lacks."""

import re
import time
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from common.cameras.camera import Camera
from common.clock import NS_PER_MS, Clock
from common.errors import CameraError
from common.messages.hand import TrackingStatus
from farhand.calibration.pictures import size_of
from farhand.doctor.findings import Finding, error, ok, warning
from farhand.setup.room import (
    ArmInPicture,
    Light,
    arm_in_picture,
    in_view,
    judge_background,
    judge_contrast,
    judge_elbow,
    judge_light,
    light_of,
)
from local_site.acquisition.capture import Capture
from local_site.acquisition.pairing import PairingConfig
from local_site.calibration.rig import Rig
from local_site.kernels.pictures import as_grey
from local_site.tracking.tracker import ArmEstimate, Tracker, TrackingReason, Views

GOOD_SHARE, POOR_SHARE, RARE_SHARE = 0.9, 0.5, 0.1
NAMED_REASONS = 3
EACH = 5  # of so many instants one is measured, which leaves the tracker its time
WAIT_S = 0.1
LEARN = "try again; hold the arm bent and still at first, thumb and index apart, in the middle of both pictures"
PROGRESS = (TrackingReason.LEARNING, TrackingReason.LEARNING_ROOM)  # how far it is, not why it fails
COUNTS = re.compile(r" \([^)]*\d[^)]*\)")

CURES: Mapping[TrackingReason, str] = {
    TrackingReason.NO_ARM: "let one arm alone be in both pictures, and nothing else that is bright",
    TrackingReason.OUT_OF_STEP: "calibrate again if a camera was touched; check that left is left",
    TrackingReason.LEFT_OPEN: "hold the forearm across the views, the elbow at a right angle",
    TrackingReason.NO_UPPER_ARM: "roll the sleeve up above the elbow, and let both cameras see some of the upper arm",
    TrackingReason.NEARLY_STRAIGHT: "bend the elbow",
    TrackingReason.FOLDED: "open the elbow to about a right angle",
    TrackingReason.FORESHORTENED: "turn so that the forearm lies across the views, or place the cameras otherwise",
    TrackingReason.PARALLEL_TO_BASELINE: "point the forearm away from the cameras, or raise one of them",
    TrackingReason.OUTSIDE_VOLUME: "work where the board was shown, or calibrate again with the board shown there",
    TrackingReason.HAND_UNCLEAR: "hold thumb and index apart, the other fingers closed, the hand across the views",
    TrackingReason.OTHER_ARM: "answer which arm is tracked again; check that left is left and no picture is mirrored",
    TrackingReason.OTHER_SIDE: "answer which arm is tracked again; check that left is left and no picture is mirrored",
    TrackingReason.THUMB_INFERRED: "turn the hand so that both cameras see the thumb",
}
OTHERWISE = "let the bent arm alone be seen by both cameras, well lit, before something dark and plain"


def without_counts(reason: str) -> str:
    """A reason without the numbers in brackets, so that the same reasons count as one."""
    return COUNTS.sub("", reason)


def cure_of(reason: str) -> str:
    """Say what to do about a reason; empty where its own sentence says it, after a colon."""
    known = next((cure for which, cure in CURES.items() if which in reason), None)
    if known is not None:
        return known
    return "" if ": " in reason else OTHERWISE


@dataclass
class TrackerTrial:
    """The pairs that a trial has seen, by the names of the views; `ms` is the time that each instant took to track.

    `statuses` are those of the instants after the `learning` ones, in which the tracker still learned arm or room.
    """

    names: tuple[str, ...]
    statuses: Counter[TrackingStatus] = field(default_factory=Counter)
    reasons: Counter[str] = field(default_factory=Counter)
    elbows: dict[str, list[bool]] = field(default_factory=dict)
    lights: dict[str, list[Light]] = field(default_factory=dict)
    arms: dict[str, list[ArmInPicture]] = field(default_factory=dict)
    ms: list[float] = field(default_factory=list)
    learning: int = 0

    def count(self, estimate: ArmEstimate) -> None:
        """Count an instant."""
        if estimate.status is TrackingStatus.INITIALISING:
            self.learning += 1
        else:
            self.statuses[estimate.status] += 1
        reason = without_counts(estimate.reason)
        if reason and reason not in PROGRESS:
            self.reasons[reason] += 1

    @property
    def tracked_share(self) -> float:
        """The fraction of instants in which the arm was tracked, well or with doubts."""
        tracked = self.statuses[TrackingStatus.TRACKED] + self.statuses[TrackingStatus.DEGRADED]
        return tracked / max(self.statuses.total(), 1)


def views_for(cameras: Sequence[Camera], pairing: PairingConfig, clock: Clock, seconds: float) -> Iterator[Views]:
    """The newest views of running cameras for so long, without those that come while one is worked on.

    CameraError if a camera fails, or no views come.
    """
    capture = Capture(cameras, pairing, clock)
    try:
        end_ns, came = clock.now_ns() + round(seconds * 1e3 * NS_PER_MS), False
        while clock.now_ns() < end_ns and not capture.ended:
            if (views := capture.next(WAIT_S)) is not None:
                came = True
                yield views
        if capture.ended or not came:
            raise CameraError(capture.problem() or "no pair of pictures of one instant came; check both cameras")
    finally:
        capture.close()


def run_trial(rig: Rig, tracker: Tracker, views: Iterable[Views]) -> TrackerTrial:
    """Track all views, and measure light, contrast and the elbow's place in some of them."""
    trial = TrackerTrial(tuple(camera.name for camera in rig.cameras))
    for k, pair in enumerate(views):
        begin_s = time.perf_counter()
        estimate = tracker.track(pair)
        trial.ms.append(1e3 * (time.perf_counter() - begin_s))
        trial.count(estimate)
        if k % EACH == 0:
            _measure(trial, rig, pair, estimate)
    return trial


def _measure(trial: TrackerTrial, rig: Rig, pair: Views, estimate: ArmEstimate) -> None:
    for k, (camera, view) in enumerate(zip(rig.cameras, pair.views, strict=True)):
        picture = view.current.image
        trial.lights.setdefault(camera.name, []).append(light_of(as_grey(picture)))
        contour = estimate.overlays[k].contour if k < len(estimate.overlays) else None
        arm = None if contour is None else arm_in_picture(picture, contour)
        if arm is not None:
            trial.arms.setdefault(camera.name, []).append(arm)
        if estimate.elbow is not None:
            projected = camera.matrix @ np.append(estimate.elbow, 1.0)
            pixel = camera.distort_pixels(projected[:2] / projected[2])
            trial.elbows.setdefault(camera.name, []).append(in_view(pixel, size_of(picture)))


def judge_trial(trial: TrackerTrial, needs_dark: bool) -> list[Finding]:
    """The trial's findings: the fraction tracked, the most frequent reasons, and what the room lacks."""
    if not trial.ms:
        return [error("tracked", "no pair of pictures came", "start the trial again, and check both cameras")]
    findings = [_judge_share(trial), *_judge_reasons(trial)]
    for name in trial.names:
        arms = trial.arms.get(name, [])
        lights, where = ([arm.light for arm in arms], "on the arm") if arms else (trial.lights[name], "whole picture")
        findings.append(judge_light(name, _middle(lights), where))
        if arms:
            findings.append(judge_contrast(name, float(np.median([arm.contrast for arm in arms])), needs_dark))
        elif needs_dark:
            findings.append(judge_background(name, _middle(lights)))
    return [*findings, judge_elbow({name: float(np.mean(seen)) for name, seen in trial.elbows.items()})]


def _middle(lights: Sequence[Light]) -> Light:
    return Light(*np.median([(light.mean, light.bright, light.saturated) for light in lights], axis=0).tolist())


def _judge_share(trial: TrackerTrial) -> Finding:
    share, count = trial.tracked_share, trial.statuses.total()
    if not count:
        return error("tracked", f"all {trial.learning} instants went by while arm or room was learned", LEARN)
    learned = f", after {trial.learning} to learn arm or room" if trial.learning else ""
    sentence = f"{100 * share:.0f} % of {count} instants, {float(np.median(trial.ms)):.0f} ms each{learned}"
    if share >= GOOD_SHARE:
        return ok("tracked", sentence)
    cure = "see the reasons below; hold the arm bent, thumb and index apart, in the middle of both pictures"
    return (warning if share >= POOR_SHARE else error)("tracked", sentence, cure)


def _judge_reasons(trial: TrackerTrial) -> list[Finding]:
    """The most frequent reasons with their cures, as warnings where too little is tracked."""
    count = len(trial.ms)
    return [
        warning("reason", f"{100 * times / count:.0f} %: {reason}", cure_of(reason))
        for reason, times in trial.reasons.most_common(NAMED_REASONS)
        if times > RARE_SHARE * count
    ]
