"""The tracker's trial on rendered pictures: what is tracked, why not, and what the room lacks."""

import threading
from functools import lru_cache

import numpy as np
import pytest

from common.clock import FakeClock
from common.errors import CameraError
from common.messages.hand import TrackingStatus
from farhand.doctor.findings import Severity
from farhand.setup.trial import (
    CURES,
    OTHERWISE,
    TrackerTrial,
    cure_of,
    judge_trial,
    run_trial,
    views_for,
    without_counts,
)
from local_site.acquisition.pairing import PairingConfig
from local_site.simulation.cameras import exact_rig
from local_site.simulation.config import SimulationConfig
from local_site.tracking.choice import TrackingConfig, make_tracker
from local_site.tracking.tracker import ArmEstimate, TrackingReason
from tests.farhand.setup.operator_views import FilmedCamera, before_a_wall, filmed, views_of

COUNT = 30
RIG = exact_rig(SimulationConfig().stereo)
pictures = lru_cache(filmed)


def tried(instants):
    return run_trial(RIG, make_tracker(RIG, TrackingConfig()), views_of(instants))


def finding(findings, check):
    return next(one for one in findings if one.check == check)


def test_a_good_room_has_no_warnings():
    trial = tried(pictures(COUNT))
    assert trial.learning == 10
    assert trial.statuses.total() == COUNT - 10
    findings = judge_trial(trial, needs_dark=True)
    assert {one.level for one in findings if one.check != "reason"} == {Severity.OK}, findings
    assert finding(findings, "elbow in view").sentence == "left 100 %, right 100 %"


def test_a_bright_wall_is_named_as_what_keeps_the_arm_from_being_tracked():
    findings = judge_trial(tried(before_a_wall(pictures(10), 150)), needs_dark=True)
    assert finding(findings, "tracked").level is Severity.ERROR
    assert finding(findings, "tracked").sentence.startswith("0 % of 10 instants")
    assert finding(findings, "reason").sentence.startswith("100 %: ")
    assert finding(findings, "contrast left").cure.startswith("a darker and plainer background")
    assert finding(findings, "elbow in view").sentence == "never found"


def test_a_dark_room_is_told():
    dim = [[(picture * 0.2).astype(np.uint8) for picture in pair] for pair in pictures(10)]
    findings = judge_trial(tried(dim), needs_dark=True)
    assert finding(findings, "light right").cure.startswith("more light on the arm")


class EstimatesTracker:
    """Tracks as scripted, whatever it sees."""

    def __init__(self, estimates):
        self._estimates = iter(estimates)

    def track(self, views):
        status, reason, elbow = next(self._estimates)
        return ArmEstimate(views.t_ns, status, reason, elbow=elbow)


def scripted(*estimates):
    return run_trial(RIG, EstimatesTracker(estimates), views_of(pictures(len(estimates))))


def test_the_most_frequent_reasons_come_first_with_their_cures_and_rare_ones_are_left_out():
    lost = TrackingStatus.LOST
    trial = scripted(
        *[(lost, f"{TrackingReason.FOLDED}", None)] * 3,
        *[(lost, f"{TrackingReason.LEFT_OPEN} (view {k})", None) for k in range(6)],
        (lost, TrackingReason.NO_ARM, None),
    )
    reasons = [one for one in judge_trial(trial, needs_dark=False) if one.check == "reason"]
    assert [one.sentence for one in reasons] == [f"60 %: {TrackingReason.LEFT_OPEN}", f"30 %: {TrackingReason.FOLDED}"]
    assert [one.cure for one in reasons] == [CURES[TrackingReason.LEFT_OPEN], CURES[TrackingReason.FOLDED]]


def test_an_elbow_outside_one_picture_is_seen_by_its_projection():
    left = np.linalg.inv(RIG.matrices[0][:, :3])
    centre = -left @ RIG.matrices[0][:, 3]
    at_the_left_edge = centre + 1.2 * left @ np.array([3.0, 240.0, 1.0]) / np.linalg.norm(left @ [3.0, 240.0, 1.0])
    trial = scripted((TrackingStatus.TRACKED, "", at_the_left_edge))
    assert trial.elbows["left"] == [False]


def test_learning_counts_neither_for_nor_against_tracking():
    learning = (TrackingStatus.INITIALISING, f"{TrackingReason.LEARNING} (3 of 10 pairs)", None)
    trial = scripted(*[learning] * 4, (TrackingStatus.TRACKED, "", None))
    assert finding(judge_trial(trial, needs_dark=False), "tracked").sentence.startswith("100 % of 1 instants")
    assert not trial.reasons
    only = finding(judge_trial(scripted(learning), needs_dark=False), "tracked")
    assert only.level is Severity.ERROR
    assert only.sentence == "all 1 instants went by while arm or room was learned"


@pytest.mark.parametrize(("good", "level"), [(10, Severity.OK), (7, Severity.WARNING), (3, Severity.ERROR)])
def test_the_share_that_is_tracked_decides(good, level):
    statuses = [TrackingStatus.TRACKED, TrackingStatus.DEGRADED] * 5
    trial = scripted(*[(s, "", None) for s in statuses[:good]], *[(TrackingStatus.LOST, "x", None)] * (10 - good))
    assert finding(judge_trial(trial, needs_dark=False), "tracked").level is level


def test_a_trial_without_pictures_is_an_error():
    (only,) = judge_trial(TrackerTrial(("left", "right")), needs_dark=True)
    assert only.level is Severity.ERROR


def test_reasons_that_tell_their_cure_need_no_other():
    assert cure_of("left: arm and background have no clear valley between them: darken the background") == ""
    assert cure_of(f"left: {TrackingReason.OUT_OF_STEP}") == CURES[TrackingReason.OUT_OF_STEP]
    assert cure_of("a reason without a cure") == OTHERWISE
    assert without_counts("learning (3 of 10 pairs): hold") == "learning: hold"


def test_running_cameras_that_end_are_told_and_closed():
    cameras = [FilmedCamera(name, [pair[k] for pair in pictures(3)]) for k, name in enumerate(("left", "right"))]
    with pytest.raises(CameraError, match="has come to its end"):
        list(views_for(cameras, PairingConfig(), FakeClock(), 10.0))


def test_views_end_with_the_time_and_the_cameras_are_closed():
    class Open(FilmedCamera):
        """Waits after its last frame until it is closed."""

        def __init__(self, name, own):
            super().__init__(name, own)
            self.closed = threading.Event()

        def read(self):
            return super().read() or (self.closed.wait() and None)

        def close(self):
            self.closed.set()

    clock = FakeClock()
    cameras = [Open(name, [pair[k] for pair in pictures(3)]) for k, name in enumerate(("left", "right"))]
    views = views_for(cameras, PairingConfig(), clock, 10.0)
    assert len(next(views).views) == 2
    clock.advance_ms(10_001)
    assert list(views) == []
    assert all(camera.closed.is_set() for camera in cameras)
