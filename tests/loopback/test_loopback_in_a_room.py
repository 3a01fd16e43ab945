"""The whole loop in an ordinary room: the operator comes in, is found by the hand's landmarks, and moves the arm."""

from pathlib import Path

import cv2
import numpy as np
import pytest

from common.errors import ModelError
from local_site.simulation.cameras import exact_rig
from local_site.simulation.config import StereoConfig
from local_site.tracking.landmarks.models import view_hands
from tests.loopback.undisturbed import run_loopback
from tests.present import present

MAX_FOLLOW_MM = 30.0
MAX_ERROR_MM = {"elbow": 20.0, "wrist": 15.0, "index": 20.0, "thumb": 20.0}

pytestmark = pytest.mark.long


def test_the_loop_closes_in_a_room(tmp_path: Path) -> None:
    try:
        view_hands(exact_rig(StereoConfig()), right_arm=True)
    except ModelError as missing:
        pytest.skip(str(missing))
    report, views = tmp_path / "out.json", tmp_path / "views"
    command = ["--seconds", "9", "--headless", "--tracker", "learned", "--save-views", str(views)]
    command += ("--set", "simulation.fps=10")  # both cameras and the tracker in real time fill two processors at 15
    figures = run_loopback(*command, report=report, timeout_s=180)
    assert figures["engagements"] == 1
    assert figures["follow_mm"]["mean"] < MAX_FOLLOW_MM
    for point, most_mm in MAX_ERROR_MM.items():
        assert figures["tracking"]["error_mm"][point]["mean"] < most_mm, point
    assert not any("XNNPACK" in event for event in figures["events"])
    picture = present(cv2.imread(str(views / "operator_left.png")))
    assert np.ptp(picture[-40:, :40].astype(int), axis=2).max() > 20, "the room is in colour"
