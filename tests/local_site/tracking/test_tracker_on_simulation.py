"""The tracker on the simulated operator: other bodies, loss and return, cameras that do not expose together."""

from dataclasses import dataclass

import numpy as np
import pytest

from common.cameras.camera import Frame
from common.messages import TrackingStatus
from local_site.simulation.cameras import exact_rig
from local_site.simulation.config import BodyConfig, MotionConfig, SimulationConfig
from local_site.simulation.operator import SimulatedOperator
from local_site.tracking.silhouette.silhouette_tracker import SilhouetteTracker
from local_site.tracking.tracker import View, Views

PERIOD_S = 1 / 30
THIN = BodyConfig(forearm_girth=0.20, upper_arm_girth=0.22, elbow_girth=0.20, wrist_girth=0.14, belly_offset=0.004)
STRONG = BodyConfig(forearm_girth=0.32, upper_arm_girth=0.36, elbow_girth=0.28, wrist_girth=0.185, belly_offset=0.018)
MOVING = MotionConfig(name="figure_of_eight", still_s=0.4)


@dataclass
class Scene:
    """An operator with a tracker before him."""

    operator: SimulatedOperator
    tracker: SilhouetteTracker

    def frame(self, k, camera, late_s=0.0):
        t = k * PERIOD_S + late_s
        return Frame(self.operator.render(t, (camera,))[0], round(t * 1e9), k)

    def step(self, k):
        views = tuple(View(self.frame(k, camera)) for camera in (0, 1))
        return self.tracker.track(Views(views[0].current.capture_ns, views))


def scene(body=None, motion=MOVING):
    config = SimulationConfig(body=body or BodyConfig(), motion=motion)
    return Scene(SimulatedOperator(config), SilhouetteTracker(exact_rig(config.stereo)))


@pytest.mark.parametrize("body", [THIN, BodyConfig(), STRONG])
def test_bodies_of_any_build_are_tracked(body):
    at = scene(body)
    estimates = [at.step(k) for k in range(45)]
    assert [e.status for e in estimates[:10]] == [TrackingStatus.INITIALISING] * 10
    after = estimates[10:]
    assert all(e.status is not TrackingStatus.LOST for e in after)
    wrist = [np.linalg.norm(e.wrist - at.operator.truth(k * PERIOD_S).wrist) for k, e in enumerate(after, start=10)]
    assert max(wrist) < 0.03
    assert sum(e.index is not None for e in after) >= 33


@pytest.mark.parametrize("body", [THIN, STRONG])
def test_the_index_is_not_its_neighbour(body):
    at = scene(body)
    errors = []
    for k in range(25):
        estimate, truth = at.step(k), at.operator.truth(k * PERIOD_S)
        errors.append((np.linalg.norm(estimate.index - truth.index), np.linalg.norm(estimate.thumb - truth.thumb)))
    assert np.all(np.mean(errors, axis=0) < 0.006)


def test_a_loss_is_reported_and_over_when_the_arm_is_back():
    at = scene()
    for k in range(15):
        at.step(k)
    dark = Frame(np.full((480, 640), 9, np.uint8), round(15 * PERIOD_S * 1e9), 15)
    lost = at.tracker.track(Views(dark.capture_ns, (View(dark), View(dark))))
    assert lost.status is TrackingStatus.LOST
    assert lost.wrist is None
    assert "no arm" in lost.reason
    assert at.step(16).status in (TrackingStatus.TRACKED, TrackingStatus.DEGRADED)


def test_one_camera_that_froze_long_ago_is_not_followed():
    at = scene(motion=MotionConfig(name="pick_and_place", still_s=0.4))
    for k in range(15):
        at.step(k)
    frozen = at.frame(14, 1)
    estimates = [
        at.tracker.track(Views(round(k * PERIOD_S * 1e9), (View(at.frame(k, 0)), View(frozen))))
        for k in range(40, 80, 8)
    ]
    assert any(e.status is TrackingStatus.LOST for e in estimates)


def test_cameras_out_of_phase_are_brought_to_one_instant():
    late = 0.5 * PERIOD_S
    together, apart = scene(), scene()
    errors = []
    for k in range(1, 50):
        together.step(k)
        right = View(apart.frame(k, 1, late), apart.frame(k - 1, 1, late), weight=0.5)
        estimate = apart.tracker.track(Views(round(k * PERIOD_S * 1e9), (View(apart.frame(k, 0)), right)))
        reference = together.step(k)
        if k > 20:
            errors.append(np.linalg.norm(estimate.wrist - reference.wrist))
    assert np.mean(errors) < 0.002
