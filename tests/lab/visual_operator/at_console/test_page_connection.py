"""The operator's page at a console that runs: pictures come, key and settings go, the hand is led."""

import socket
import time
from contextlib import ExitStack
from functools import partial

import msgspec
import pytest

from common.errors import TransportError
from common.messages.hand import Intent, Locks, OperatorSettings
from common.messages.robot import SessionState
from farhand.loopback.site_process import free_ports
from lab.measure.page import scene
from lab.measure.page.bare_console import BareConsole
from lab.stage.waiting import until
from lab.visual_operator.at_console import page_connection
from lab.visual_operator.at_console.console_page import ConsolePage
from lab.visual_operator.at_console.led_pose import LedPose, LedPoses
from lab.visual_operator.at_console.page_connection import PageConnection

PATIENCE_S = 30.0


@pytest.fixture
def console():
    with BareConsole() as console:
        yield console


def port_of(console):
    return int(console.address.rsplit(":", 1)[1].strip("/"))


def feed(console, seq):
    state = scene.state(SessionState.ENGAGED, "ok", "")
    console.feed(lambda hub: (hub.described(scene.cell()), hub.state(state), hub.hand(scene.hand())))
    for camera in scene.CAMERAS:
        console.feed(lambda hub, camera=camera: hub.camera(scene.picture(camera, seq, scene.plain(80))))


def test_pictures_come_the_key_goes_and_settings_are_set(console, tmp_path):
    with PageConnection(port_of(console), str(tmp_path / "hand"), ConsolePage()) as connection:
        until(lambda: console.watched)
        for seq in range(1, 4):  # as many as nobody would get who does not say that they are painted
            feed(console, seq)
            until(partial(lambda seq: [view.seq for view in connection.page.painted.values()] == 4 * [seq], seq))
        until(lambda: connection.page.lacks() == "")
        until(lambda: console.intents and not console.intents[-1].intent.hold)
        wanted = OperatorSettings(lease=1, revision=9, scale=0.25, rotation_scale=0.5, locks=Locks(roll=True))
        connection.intent = Intent(hold=True, settings=wanted, assist="block")
        until(lambda: console.intents[-1].intent.hold and console.intents[-1].intent.assist == "block")
        until(lambda: console.intents[-1].intent.settings.scale == 0.25)
        sent = console.intents[-1].intent.settings
        assert (sent.lease, sent.rotation_scale, sent.locks) == (5, 0.5, Locks(roll=True))
        until(lambda: console.shown and set(console.shown[-1].views) == set(scene.CAMERAS))
    assert not console.shown[-1].h264


def test_the_hands_poses_go_to_its_socket(console, tmp_path):
    name = str(tmp_path / "hand")
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as cameras:
        cameras.bind(f"{name}.1")
        cameras.settimeout(PATIENCE_S)
        with PageConnection(port_of(console), name, ConsolePage()) as connection:
            connection.hand = lambda now_ns: [LedPose(t_ns=now_ns, offset=(0.1, 0.0, 0.0), turn=(0.0, 0.0, 0.0))]
            poses = msgspec.json.decode(cameras.recv(1 << 16), type=LedPoses)
    assert poses[0].offset == (0.1, 0.0, 0.0)
    assert 0 < time.monotonic_ns() - poses[0].t_ns < PATIENCE_S * 1e9


def test_a_console_that_ends_is_noticed():
    ending = ExitStack()
    with BareConsole() as console:
        open_ = PageConnection(port_of(console), "unused", ConsolePage())
        ending.enter_context(open_)
        until(lambda: console.watched)
    until(lambda: open_.is_over)
    ending.close()


def test_a_missing_console_is_named(monkeypatch):
    monkeypatch.setattr(page_connection, "ATTEMPTS", 1)
    with pytest.raises(TransportError, match="farhand console"):
        PageConnection(free_ports(1)[0], "unused", ConsolePage())
