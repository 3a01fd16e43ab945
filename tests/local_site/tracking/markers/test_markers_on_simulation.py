"""The marker tracker on the simulated operator: errors below a millimetre, every opening counted, fast and blurred."""

import numpy as np
import pytest

from common.cameras.camera import Frame
from common.messages.hand import TrackingStatus
from local_site.samples.hand_sample import GestureConfig, OpenHand
from local_site.simulation.cameras import exact_rig
from local_site.simulation.config import MotionConfig, PictureConfig, SimulationConfig
from local_site.simulation.operator import SimulatedOperator
from local_site.tracking.choice import TrackingConfig, make_tracker
from local_site.tracking.tracker import View, Views

NAMES = ("wrist", "index", "thumb")


def followed(motion, seconds, picture=None, step_s=1 / 30):
    """Errors (N, 3) in mm of the settled instants, their statuses, and openings counted and made."""
    config = SimulationConfig(
        markers=True, motion=MotionConfig(name=motion, still_s=0.4), picture=picture or PictureConfig()
    )
    operator = SimulatedOperator(config)
    tracker = make_tracker(exact_rig(config.stereo), TrackingConfig(method="markers"))
    hand, errors, statuses = OpenHand(), [], []
    times = [*np.arange(0.0, 0.4, 1 / 30), *np.arange(0.4, seconds, step_s)]
    for k, t_s in enumerate(times):
        t_ns = round(t_s * 1e9)
        views = tuple(View(Frame(image, t_ns, k)) for image in operator.render(t_s))
        estimate = tracker.track(Views(t_ns, views))
        hand = hand.observe(estimate, GestureConfig())
        truth = operator.truth(t_s)
        if k >= 10:
            assert all(getattr(estimate, name) is not None for name in NAMES), estimate.reason
            errors.append([1e3 * np.linalg.norm(getattr(estimate, n) - getattr(truth, n)) for n in NAMES])
            statuses.append(estimate.status)
    return np.array(errors), statuses, (hand.toggles, operator.motion.openings_until(times[-1]))


@pytest.mark.slow
@pytest.mark.parametrize("motion", ["pick_and_place", "rotate_x", "rotate_y", "rotate_z", "figure_of_eight"])
def test_motions_are_followed_within_half_a_millimetre(motion):
    errors, statuses, _ = followed(motion, 8.0, step_s=0.16)
    assert errors.max() < 0.5
    assert np.mean([status is TrackingStatus.TRACKED for status in statuses]) > 0.97


@pytest.mark.slow
def test_every_opening_of_the_hand_is_counted_once():
    _, _, (counted, made) = followed("toggles", 5.2)
    assert counted == made == 3


def test_motion_blur_does_not_lose_the_markers():
    errors, _, _ = followed("pick_and_place", 3.0, PictureConfig(shutter_ms=20.0), step_s=1 / 15)
    assert errors.mean(axis=0).max() < 0.5
