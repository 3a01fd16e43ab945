"""The arm in the office is good enough for a network that was trained on photographs: it finds the hand's joints."""

import numpy as np
import pytest

from local_site.simulation.cameras import stereo_pair
from local_site.simulation.config import MotionConfig, SimulationConfig
from local_site.simulation.operator import SimulatedOperator
from local_site.simulation.room.config import RoomConfig
from local_site.tracking.landmarks.model_files import HAND_LANDMARKS, PALM_DETECTION, model_folder

pytest.importorskip("ai_edge_litert")

TIPS = {8: 0, 4: 4}  # of the network's points: index and thumb
SEARCHES = 5
NEAR_PX = 10.0


@pytest.fixture(scope="module")
def followers():
    """One for each view."""
    from local_site.tracking.landmarks.hand_landmarks import HandLandmarker
    from local_site.tracking.landmarks.network import LandmarkNetwork
    from local_site.tracking.landmarks.palm_detector import PalmDetector
    from local_site.tracking.landmarks.view_follower import ViewFollower

    files = [model_folder() / model.name for model in (PALM_DETECTION, HAND_LANDMARKS)]
    if not all(file.exists() for file in files):
        pytest.skip("the landmark models are not installed")
    palms, hands = (LandmarkNetwork(file.read_bytes(), outputs) for file, outputs in zip(files, (2, 3), strict=True))
    return lambda: [ViewFollower(PalmDetector(palms), *[HandLandmarker(hands)] * 2) for _ in range(2)]


def hand_of(follower, image):
    """Found, then followed, as a tracker does with a hand that keeps still."""
    for _ in range(SEARCHES):
        found = [hand for hand in follower.search(image) if hand.score >= 0.5]
        if found:
            follower.keep(found[0])
            return follower.follow(image, quickly=False)
    return None


@pytest.mark.slow
@pytest.mark.parametrize("skin", ["light", "medium", "dark"])
@pytest.mark.parametrize(("motion", "t_s"), [("pick_and_place", 5.0), ("figure_of_eight", 4.0), ("rotate_y", 4.5)])
def test_the_hand_is_found_where_it_is(followers, skin, motion, t_s):
    config = SimulationConfig(room=RoomConfig(scene="office", skin=skin), motion=MotionConfig(name=motion))
    operator, cameras = SimulatedOperator(config), stereo_pair(config.stereo)
    joints = operator.joints(t_s)
    for follower, camera, image in zip(followers(), cameras, operator.render(t_s), strict=True):
        hand = hand_of(follower, image)
        assert hand is not None
        for number, digit in TIPS.items():
            pixel = camera.pixels(camera.to_camera(joints[digit, 3]))
            assert np.hypot(*(hand.points[number] - pixel)) < NEAR_PX
