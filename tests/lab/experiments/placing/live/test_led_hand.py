"""A simulated hand that another program leads: poses over a socket, and what is filmed of them."""

import os
import socket
import time

import msgspec
import numpy as np
import pytest

from common.clock import NS_PER_MS, NS_PER_S
from lab.experiments.placing.live.led_hand import LedHand, LedPoseHistory
from lab.experiments.placing.live.led_local import film_led
from lab.stage.waiting import until
from lab.visual_operator.at_console.led_pose import LedPose
from local_site.simulation.config import MotionConfig, PictureConfig, SimulationConfig, StereoConfig
from local_site.tracking.choice import TrackingConfig
from tests.present import present

SMALL = StereoConfig(width_px=160, height_px=120, focal_px=200.0)


def pose(t_ns, x=0.0, turn=0.0, openness=0.0, openings=0):
    return LedPose(t_ns=t_ns, offset=(x, 0.0, 0.0), turn=(0.0, 0.0, turn), openness=openness, openings=openings)


def send(name, *poses):
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as sender:
        sender.sendto(msgspec.json.encode(poses), name)


def test_the_hand_moves_evenly_between_two_poses_and_rests_before_and_after():
    history = LedPoseHistory()
    assert [part.tolist() for part in history.at(5)[:2]] == [[0, 0, 0], [0, 0, 0]]
    history.add(pose(100, x=0.1, turn=0.2))
    history.add(pose(200, x=0.3, turn=0.6, openness=1.0, openings=1))
    at = {t_ns: history.at(t_ns) for t_ns in (50, 100, 150, 200, 900)}
    assert [at[t][0][0] for t in at] == pytest.approx([0.1, 0.1, 0.2, 0.3, 0.3])
    assert [at[t][1][2] for t in at] == pytest.approx([0.2, 0.2, 0.4, 0.6, 0.6])
    assert [at[t][2] for t in at] == pytest.approx([0.0, 0.0, 0.5, 1.0, 1.0])
    assert [history.openings_until(t) for t in (50, 150, 200)] == [0, 0, 1]


def test_an_older_pose_has_no_effect_and_the_last_second_is_kept():
    history = LedPoseHistory()
    for k in range(30):
        history.add(pose(k * 100 * NS_PER_MS, x=float(k)))
    history.add(pose(100 * NS_PER_MS, x=-5.0))
    assert history.at(29 * 100 * NS_PER_MS)[0][0] == 29.0
    assert history.at(1950 * NS_PER_MS)[0][0] == pytest.approx(19.5)
    assert history.at(0)[0][0] > 10.0


def test_what_is_no_pose_is_refused_and_the_next_counts(tmp_path):
    name = str(tmp_path / "hand")
    hand = LedHand(name, lambda t_s: round(t_s * NS_PER_S))
    assert hand.at(0.0)[0].tolist() == [0.0, 0.0, 0.0]
    name = f"{name}.{os.getpid()}"
    for wrong in (b"{", b'[{"t_ns": -1}]', b'[{"t_ns": 1, "offset": [1, 2], "turn": [0, 0, 0]}]'):
        with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as sender:
            sender.sendto(wrong, name)
    send(name, pose(NS_PER_S, x=0.5))
    assert hand.at(1.0)[0][0] == 0.5


def test_each_camera_films_where_the_hand_is_led(tmp_path):
    motion = MotionConfig(begins="at_once", still_s=0.0)
    config = SimulationConfig(stereo=SMALL, fps=50.0, motion=motion, picture=PictureConfig(noise_sigma=0.0))
    cameras = film_led(str(tmp_path / "hand"), config, TrackingConfig()).cameras
    try:
        before = [present(camera.read()).image for camera in cameras]
        assert [
            np.array_equal(present(camera.read()).image, seen) for camera, seen in zip(cameras, before, strict=True)
        ]
        sockets = [str(path) for path in tmp_path.glob("hand.*")]
        assert len(sockets) == 2
        for name in sockets:
            send(name, pose(time.monotonic_ns(), x=-0.1))

        def have_all_changed() -> bool:
            pairs = zip(cameras, before, strict=True)
            return not any(np.array_equal(present(camera.read()).image, seen) for camera, seen in pairs)

        until(have_all_changed, "other pictures")
    finally:
        for camera in cameras:
            camera.close()
