"""A simulated hand that another program leads: poses over a socket, and what is filmed of them."""

import socket
import time

import msgspec
import numpy as np
import pytest

from common.clock import NS_PER_MS, NS_PER_S
from common.errors import ConfigError
from common.messages.led_hand import LedPose
from local_site.acquisition.led_hand import LedHand, LedPoseHistory
from local_site.acquisition.simulated_cameras import SimulatedCameras
from local_site.simulation.config import MotionConfig, PictureConfig, SimulationConfig, StereoConfig

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
    for wrong in (b"{", b'[{"t_ns": -1}]', b'[{"t_ns": 1, "offset": [1, 2], "turn": [0, 0, 0]}]'):
        with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as sender:
            sender.sendto(wrong, name)
    send(name, pose(NS_PER_S, x=0.5))
    assert hand.at(1.0)[0][0] == 0.5


def test_a_socket_that_cannot_be_made_is_named_with_the_cure(tmp_path):
    with pytest.raises(ConfigError, match=r"led_by.*folder"):
        LedHand(str(tmp_path / "missing" / "hand"), round)


def test_the_cameras_film_where_the_hand_is_led(tmp_path):
    name = str(tmp_path / "hand")
    motion = MotionConfig(led_by=name, still_s=0.0)
    config = SimulationConfig(stereo=SMALL, fps=100.0, motion=motion, picture=PictureConfig(noise_sigma=0.0))
    source = SimulatedCameras(config)
    try:
        camera = source.cameras[0]
        before = camera.read().image
        assert np.array_equal(camera.read().image, before)
        send(name, pose(time.monotonic_ns(), x=-0.1))
        deadline = time.monotonic() + 30
        while np.array_equal(camera.read().image, before):
            assert time.monotonic() < deadline, "the picture never changed"
    finally:
        source.close()


def test_a_led_hand_is_of_no_textured_arm():
    with pytest.raises(ValueError, match="led_by"):
        SimulationConfig(textured=True, motion=MotionConfig(led_by="hand"))
