"""From the page and the cameras to the lines of the configuration, with a screen and cameras that are made up."""

import json
import urllib.error
import urllib.request

import msgspec
import numpy as np
import pytest

from common.cameras.camera import Frame
from common.clock import FakeClock
from common.config.loading import load_config
from common.errors import CameraError, ConfigError, InterruptionError
from farhand.calibration.cameras import CameraSetup, configured_cameras
from farhand.calibration.latency.measuring import describe, measure, open_for_latency, watch_screen
from farhand.calibration.latency.page import PatternPage, page_text
from farhand.calibration.latency.pattern import pattern_of, sequence
from local_site.config import LocalConfig
from tests.farhand.calibration.latency.shown_screen import REFRESH_MS, seen, shown

PATTERN = pattern_of(shown())


class CameraBeforeScreen:
    """Sees the screen in the middle of its pictures, and ends."""

    def __init__(self, name, delay_ms, *, by_driver=False, failure=None, **light):
        self.name = name
        stamps_ns, brightness = seen(PATTERN, delay_ms, rate_hz=29.97, **light)
        self._frames = iter(zip(stamps_ns.tolist(), brightness.tolist(), strict=True))
        self._by_driver = by_driver
        self._failure = failure

    def read(self):
        if self._failure:
            raise CameraError(self._failure)
        stamp_ns, level = next(self._frames, (None, 0.0))
        if stamp_ns is None:
            return None
        image = np.full((120, 160, 3), 40, dtype=np.uint8)
        image[40:90, 50:120] = np.uint8(np.clip(level, 0, 255))
        return Frame(image, stamp_ns, 0, capture_estimated=not self._by_driver)

    def close(self):
        pass


class FakeScreen:
    """Has shown the pattern at once, or never."""

    def __init__(self, report):
        self._report = report

    def wait(self, _timeout_s):
        return self._report


def measured(*cameras, screen_ms=None):
    return measure(*watch_screen(cameras, FakeScreen(shown()), lambda: False), screen_ms)


@pytest.mark.slow
def test_each_camera_gets_its_own_latency_less_the_screens():
    cameras = CameraBeforeScreen("left", 60.0), CameraBeforeScreen("right", 72.0, by_driver=True)
    latencies, refused = measured(*cameras, screen_ms=20.0)
    assert refused == []
    assert [latency.latency_ms for latency in latencies] == pytest.approx([40.0, 52.0], abs=1.0)
    text = describe(latencies, 20.0)
    assert "[operator.camera.left]\nlatency_ms = 4" in text
    assert "[operator.camera.right]\nstamp_latency_ms = 5" in text
    assert "screen's own" not in text


def test_an_unknown_screen_is_one_refresh_and_said_to_be_unknown():
    latencies, _ = measured(CameraBeforeScreen("left", 60.0))
    assert latencies[0].latency_ms == pytest.approx(60.0 - REFRESH_MS, abs=1.0)
    assert "16.7 ms, one refresh, is taken off, and all latencies may be wrong by as much" in describe(latencies, None)


def test_a_camera_that_sees_no_screen_does_not_spoil_the_other():
    latencies, refused = measured(CameraBeforeScreen("left", 60.0, contrast=2.0), CameraBeforeScreen("right", 60.0))
    assert [latency.name for latency in latencies] == ["right"]
    assert len(refused) == 1
    assert refused[0].startswith("camera left: it sees the screen change by")


def test_a_screen_slower_than_everything_together_is_refused():
    _, refused = measured(CameraBeforeScreen("left", 60.0), screen_ms=90.0)
    assert "--screen-ms must be less" in refused[0]


@pytest.mark.slow
def test_only_the_drivers_stamps_may_come_before_the_exposure():
    by_driver, by_arrival = CameraBeforeScreen("left", 10.0, by_driver=True), CameraBeforeScreen("right", 10.0)
    latencies, _ = measured(by_driver, by_arrival)
    assert latencies[0].latency_ms == pytest.approx(10.0 - REFRESH_MS, abs=1.0)
    assert latencies[1].latency_ms == 0.0


def test_a_camera_that_fails_ends_the_measurement_with_its_reason():
    with pytest.raises(CameraError, match="unplugged"):
        watch_screen([CameraBeforeScreen("left", 0.0, failure="unplugged")], FakeScreen(None), lambda: False)


def test_ctrl_c_ends_it():
    with pytest.raises(InterruptionError, match="before the screen"):
        watch_screen([CameraBeforeScreen("left", 0.0)], FakeScreen(None), lambda: True)


def test_a_recording_is_refused(tmp_path):
    (tmp_path / "0.png").write_bytes(b"")
    with pytest.raises(CameraError, match="a recording has no latency"):
        open_for_latency({"left": str(tmp_path)}, CameraSetup())


def test_the_setup_comes_from_a_local_sites_file(tmp_path):
    assert configured_cameras(None, ["left"]) == CameraSetup()
    file = tmp_path / "local.toml"
    file.write_text('[operator]\nleft = 0\nright = 1\nrig = "rig.json"\nfps = 60.0\n[operator.cameras]\ngain = 3\n')
    setup = configured_cameras(load_config(LocalConfig, file), ["left", "right"])
    assert setup.fps == 60.0
    assert setup.settings["right"].gain == 3


@pytest.fixture
def page():
    with PatternPage(FakeClock(10**17 + 1), "token") as page:
        yield page


def ask(url, content=None):
    with urllib.request.urlopen(url, content, timeout=10) as answer:  # noqa: S310  # our own server
        return answer.read().decode()


def test_the_page_shows_the_sequence_and_reads_the_clock_to_the_nanosecond(page):
    assert f"const LEVELS = {json.dumps(sequence())};" in ask(page.url) == page_text()
    assert ask(f"{page.url}clock") == str(10**17 + 1)


def test_the_page_reports_once_and_only_what_is_a_report(page):
    report = msgspec.to_builtins(shown())
    report["trips"] = [{**trip, "host_ns": str(trip["host_ns"])} for trip in report["trips"]]
    with pytest.raises(urllib.error.HTTPError, match="400"):
        ask(f"{page.url}report", b'{"drawn": 1}')
    assert page.wait(0.0) is None
    ask(f"{page.url}report", json.dumps(report).encode())
    assert page.wait(10.0) == shown()
    assert page.wait(0.0) is None


@pytest.mark.slow
@pytest.mark.parametrize("path", ["/", "/other/", "/token/../", "/token/x"])
def test_nobody_else_finds_the_page(page, path):
    origin = page.url.removesuffix("/token/")
    with pytest.raises(urllib.error.HTTPError, match="404"):
        ask(f"{origin}{path}")
    with pytest.raises(urllib.error.HTTPError, match="404"):
        ask(f"{origin}{path}", b"{}")


def test_a_port_that_is_taken_is_refused(page):
    port = int(page.url.split(":")[2].split("/")[0])
    with pytest.raises(ConfigError, match=f"--port {port}"):
        PatternPage(FakeClock(), "token", port)
