"""Whether a rig is that of the cameras, by the wrist's own sigma: for tracked pictures and for made-up residuals."""

from dataclasses import replace

import msgspec
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from common.clock import NS_PER_S
from common.geometry import Array
from common.messages.hand import TrackingStatus
from local_site.simulation.cameras import PinholeCamera, exact_rig, stereo_pair
from local_site.simulation.config import StereoConfig
from local_site.tracking.drift import DriftConfig, DriftWatch
from local_site.tracking.rig_fit import LEAST_PAIRS, RigFit
from local_site.tracking.silhouette.silhouette_tracker import SilhouetteTracker
from local_site.tracking.tracker import ArmEstimate, TrackingReason
from tests.local_site.tracking.rendered_arm import ABOVE, ASIDE, PAIR, Sequence, rig_of

SIGMAS = DriftConfig().misfit_sigmas
RIG = exact_rig(StereoConfig())
WRIST = np.array([0.5, 0.45, 0.5])
PX_PER_MM = 800 / 1500  # of the simulated cameras, at their volume's centre
CURE = "calibrate again, or give the file of this rig"


def turned(camera: PinholeCamera, axis: str, angle_deg: float) -> PinholeCamera:
    """A camera turned about an axis of its own."""
    turn: Array = Rotation.from_euler(axis, angle_deg, degrees=True).as_matrix()
    return replace(camera, camera_R_operator=turn @ camera.camera_R_operator)


def problem_of(sequence: Sequence, *cameras: PinholeCamera) -> str:
    """What is said of a rig with these cameras, by the pictures of the pair."""
    rig = rig_of([camera.projection for camera in cameras], 3.0)
    fit = RigFit(rig, SIGMAS)
    for estimate in sequence.tracked(SilhouetteTracker(rig)):
        fit.add(estimate)
    return fit.problem()


@pytest.mark.slow
def test_the_cameras_own_rig_fits(moving: Sequence, turning: Sequence) -> None:
    assert problem_of(moving, *PAIR) == problem_of(turning, *PAIR) == ""


@pytest.mark.slow
@pytest.mark.parametrize("axis", ["x", "z"])
@pytest.mark.parametrize("angle_deg", [2.0, -2.0])
def test_a_camera_that_is_turned_by_two_degrees_is_told(moving: Sequence, axis: str, angle_deg: float) -> None:
    assert problem_of(moving, PAIR[0], turned(PAIR[1], axis, angle_deg)).endswith(CURE)


@pytest.mark.slow
@pytest.mark.parametrize("other", [stereo_pair(StereoConfig(elevation_deg=20.0)), (PAIR[0], ABOVE), (ASIDE, PAIR[1])])
def test_the_file_of_another_rig_is_told(moving: Sequence, other: tuple[PinholeCamera, PinholeCamera]) -> None:
    assert problem_of(moving, *other).endswith(CURE)


def estimate(t_s: float, residual_px: float, sigma_mm: float = 3.0) -> ArmEstimate:
    """A tracked wrist that is known to `sigma_mm` along each axis."""
    covariances = {"wrist": np.eye(3) * (1e-3 * sigma_mm) ** 2}
    t_ns = round(t_s * NS_PER_S)
    tracked = TrackingStatus.TRACKED
    return ArmEstimate(t_ns, tracked, "", wrist=WRIST, covariances=covariances, residual_px=residual_px)


def refused(t_s: float) -> ArmEstimate:
    """A pair that the tracker lost because the views do not fit together."""
    return ArmEstimate(round(t_s * NS_PER_S), TrackingStatus.LOST, TrackingReason.OUT_OF_STEP, residual_px=30.0)


@pytest.mark.parametrize("sigma_mm", [0.5, 3.0, 12.0])
def test_the_bound_is_the_wrists_sigma_in_the_pictures(sigma_mm: float) -> None:
    below, above = RigFit(RIG, SIGMAS), RigFit(RIG, SIGMAS)
    for k in range(LEAST_PAIRS):
        explained_px = SIGMAS * sigma_mm * PX_PER_MM
        below.add(estimate(k, 0.95 * explained_px, sigma_mm))
        above.add(estimate(k, 1.05 * explained_px, sigma_mm))
    assert below.problem() == ""
    assert f"the wrist's sigma explains {SIGMAS * sigma_mm * PX_PER_MM:.1f}" in above.problem()


def test_a_residual_at_calibration_is_explained() -> None:
    poor = msgspec.structs.replace(RIG, epipolar_px=3.0)
    fits = RigFit(RIG, SIGMAS), RigFit(poor, SIGMAS)
    for fit in fits:
        for k in range(LEAST_PAIRS):
            fit.add(estimate(k, 4.0))
    assert [fit.problem() == "" for fit in fits] == [False, True]


def test_half_of_the_pairs_and_few_pairs_say_nothing() -> None:
    fit = RigFit(RIG, SIGMAS)
    for k in range(LEAST_PAIRS - 1):
        fit.add(refused(k))
    assert fit.problem() == ""
    for k in range(LEAST_PAIRS - 1):
        fit.add(estimate(k, 0.1))
    assert fit.problem() == ""
    fit.add(refused(LEAST_PAIRS))
    assert "30.0 px" in fit.problem()


def test_a_live_site_is_warned_once_by_the_last_seconds_and_not_before_it_has_seen_enough() -> None:
    told: list[str] = []
    watch = DriftWatch(RIG, DriftConfig(learn_s=2.0, window_s=4.0), told.append)
    reasons = [watch.judge(refused(k / 15)).reason for k in range(60)]
    assert not any(CURE in reason for reason in reasons[:30])
    assert reasons[-1].endswith(CURE)
    assert len(told) == 1
    assert [watch.judge(estimate(4 + k / 15, 0.1)).reason for k in range(60)][-1] == ""
