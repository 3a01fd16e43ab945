"""The doctor on this machine: ports that are taken, cameras and rigs that are none, and a whole run."""

import json
import os
import socket
import subprocess
import sys
import threading
from datetime import UTC, datetime, timedelta
from functools import partial
from pathlib import Path

import cv2
import msgspec
import numpy as np
import pytest
from typer.testing import CliRunner

from common.cameras.live import LiveCamera
from common.cameras.settings import CameraSettings
from common.clock import NS_PER_MS, FakeClock
from common.link.channels import CLOCK
from common.link.config import ON_THIS_HOST
from common.link.port_holders import holder_of_device, listener_on
from common.link.transport import open_link
from common.messages.requests import ClockAnswer
from farhand.cli import app
from farhand.doctor.cameras import check_camera, probe_camera, probe_rig
from farhand.doctor.examination import examine, which_site
from farhand.doctor.findings import Severity
from farhand.doctor.site import probe_clock, probe_port
from farhand.loopback.site_process import free_ports, options_of
from farhand.router import RouterConfig
from local_site.calibration.rig_file import save_rig
from local_site.config import LocalConfig
from local_site.console.config import ConsoleConfig
from local_site.simulation.cameras import exact_rig
from local_site.simulation.config import SimulationConfig
from remote_site.config import RemoteConfig
from remote_site.drivers.config import DRIVER_FILES, FRANKA
from remote_site.kinematics.config import RobotConfig
from tests.common.cameras.fake_capture import FakeCapture

NOW = datetime(2026, 3, 1, tzinfo=UTC)


def test_a_port_tells_who_listens() -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        port = server.getsockname()[1]
        taken = probe_port("control", f"tcp/127.0.0.1:{port}", ON_THIS_HOST)
        assert not taken.free
        assert f"(process {os.getpid()})" in taken.holder == listener_on(port)
    free = probe_port("control", f"tcp/127.0.0.1:{port}", ON_THIS_HOST)
    assert free.free
    assert listener_on(port) == ""


def test_an_endpoint_beyond_this_host_is_told() -> None:
    port = probe_port("control", "tcp/192.168.1.2:7447", ON_THIS_HOST)
    assert "would let anybody move the arm" in port.problem


def test_a_device_tells_who_has_it_open() -> None:
    ours, theirs = os.openpty()  # a device that nobody else has open
    try:
        assert f"(process {os.getpid()})" in holder_of_device(Path(os.ttyname(theirs)))
    finally:
        os.close(ours)
        os.close(theirs)


def test_a_camera_is_opened_for_a_picture(tmp_path: Path) -> None:
    cv2.imwrite(str(tmp_path / "0.png"), np.zeros((48, 64), np.uint8))
    assert probe_camera("left", str(tmp_path), 30.0).size_px == (64, 48)
    assert "does not exist" in probe_camera("left", str(tmp_path / "absent"), 30.0).problem
    assert "cannot open /dev/video97" in probe_camera("left", "/dev/video97", 30.0).problem


@pytest.mark.parametrize(("colour", "is_grey"), [((90, 90, 90), True), ((80, 100, 130), False), ((4, 4, 4), False)])
def test_a_grey_camera_is_known_by_its_picture(tmp_path: Path, colour: tuple[int, int, int], *, is_grey: bool) -> None:
    cv2.imwrite(str(tmp_path / "0.png"), np.full((48, 64, 3), colour, np.uint8))
    assert probe_camera("left", str(tmp_path), 30.0).is_grey == is_grey


def test_a_live_camera_tells_what_it_does_and_where_it_does_otherwise(monkeypatch: pytest.MonkeyPatch) -> None:
    clock = FakeClock(3600 * 10**9)
    live = partial(LiveCamera, open_source=lambda _: FakeCapture(clock), clock=clock)
    monkeypatch.setattr("common.cameras.sources.LiveCamera", live)
    facts = probe_camera("left", 97, 30.0)
    assert facts.state == "640 x 480, YUYV, 30 fps, exposure auto, gain 0, focus auto; frames are stamped by its driver"
    refused = check_camera(probe_camera("left", 97, 30.0, CameraSettings(fps=50.0)))
    assert "gives 60 fps, asked were 50" in refused.sentence
    assert "v4l2-ctl -d /dev/video97" in refused.cure


class HalfAsQuick(FakeCapture):
    """States its rate, and gives half of it, as in a dim room."""

    def read(self) -> tuple[bool, object]:
        self.clock.advance_ms(1e3 / 30)
        return super().read()


def test_a_live_camera_that_gives_half_of_what_it_states_is_a_warning(monkeypatch: pytest.MonkeyPatch) -> None:
    clock = FakeClock(3600 * 10**9)
    live = partial(LiveCamera, open_source=lambda _: HalfAsQuick(clock), clock=clock)
    monkeypatch.setattr("common.cameras.sources.LiveCamera", live)
    finding = check_camera(probe_camera("left", 97, 30.0))
    assert finding.level is Severity.WARNING
    assert "gives 15.0 pictures a second, and states: 640 x 480, YUYV, 30 fps" in finding.sentence
    assert "exposure_ms" in finding.cure


@pytest.mark.slow
def test_settings_of_a_camera_that_the_rig_lacks_are_a_mistake(tmp_path: Path) -> None:
    rig = tmp_path / "rig.json"
    save_rig(exact_rig(SimulationConfig().stereo), rig)
    file = tmp_path / "local.toml"
    file.write_text(f'[operator]\nleft = 97\nright = 98\nrig = "{rig}"\n[operator.camera.middle]\ngain = 3\n')
    findings = [finding for finding in examine(file, ()) if "operator.camera.middle" in finding.sentence]
    assert [finding.cure for finding in findings] == ["correct that name"]


def test_a_rig_tells_its_age(tmp_path: Path) -> None:
    path = tmp_path / "rig.json"
    rig = exact_rig(SimulationConfig().stereo)
    for created, days in [((NOW - timedelta(days=40)).isoformat(), 40.0), ("long ago", None)]:
        save_rig(msgspec.structs.replace(rig, created=created), path)
        assert probe_rig(str(path), NOW).age_days == (None if days is None else pytest.approx(days))
    path.write_text("{}")
    assert "not a rig file" in probe_rig(str(path), NOW).problem
    assert "cannot read the rig" in probe_rig(str(tmp_path / "absent.json"), NOW).problem


@pytest.mark.slow
def test_the_other_clock_is_asked_where_it_answers(monkeypatch: pytest.MonkeyPatch) -> None:
    (port,) = free_ports(1)
    endpoint, stop = f"tcp/127.0.0.1:{port}", threading.Event()
    with open_link(listen=(endpoint,)) as link:
        answers = link.answer(CLOCK, "cell", lambda _error: None)
        clock = FakeClock(7_000_000_000_000)

        def serve() -> None:
            while not stop.wait(0.001):
                answers.poll(lambda _question: ClockAnswer(received_ns=clock.now_ns(), answered_ns=clock.now_ns()))

        thread = threading.Thread(target=serve)
        thread.start()
        try:
            known = probe_clock("cell", endpoint)
        finally:
            stop.set()
            thread.join()
    assert known.offset_ns is not None
    assert known.uncertainty_ns > 0
    monkeypatch.setattr("farhand.doctor.site.CLOCK_TIMEOUT_NS", 200 * NS_PER_MS)
    assert probe_clock("cell", endpoint).offset_ns is None


@pytest.mark.parametrize(
    ("text", "sites"),
    [
        ("[operator]\nleft = 0\n", [LocalConfig]),
        ("[driver]\nname = 'kinematic'\n", [RemoteConfig]),
        ("cell = 'lab'\n[safety]\n", [RemoteConfig]),
        ("cell = 'lab'\n", [RemoteConfig, LocalConfig]),
        ("[links]\nrouter = 'tls/meet:7450'\n", [RemoteConfig]),
        ("[links]\nremote = 'tls/robot:7447'\n[links.tls]\nca = 'ca.pem'\n", [LocalConfig]),
        ("[links]\ncontrol = 'tls/0.0.0.0:7447'\n", [RemoteConfig]),
        ("[links]\ncontrol = 'tls/robot:7447'\nlocal = 'tcp/127.0.0.1:7457'\n", [ConsoleConfig]),
        ("[serve]\nport = 8470\n", [ConsoleConfig]),
        ("cell = 'lab'\nlisten = ['tls/0.0.0.0:7450']\n", [RouterConfig]),
        ("this is not TOML", [RemoteConfig]),
    ],
)
def test_a_file_tells_whose_it_is(text: str, sites: list[type], tmp_path: Path) -> None:
    path = tmp_path / "site.toml"
    path.write_text(text)
    assert which_site(path) == sites


def test_the_cells_consoles_and_routers_files_are_examined_too(tmp_path: Path) -> None:
    path = tmp_path / "router.toml"
    path.write_text("cell = 'lab'\nlisten = ['tls/0.0.0.0:7450']\n")
    found = [finding for finding in examine(path, ()) if finding.check in ("configuration", "links")]
    assert found[0].sentence.endswith("of the router has no mistakes")
    assert "tls needs certificates" in found[1].sentence
    path.write_text("[links]\nrouter = 'tls/meet:7450'\n")
    assert any("tls needs certificates" in finding.sentence for finding in examine(path, ()))


@pytest.mark.parametrize(("mode", "level"), [(0o644, "error"), (0o640, "ok")])
def test_a_token_that_everybody_can_read_is_found(tmp_path: Path, mode: int, level: str) -> None:
    path = tmp_path / "console.toml"
    path.write_text("[serve]\ntoken = '0123456789abcdef'\n")
    path.chmod(mode)
    assert [finding.level for finding in examine(path, ()) if finding.check == "page's token"] == [level]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("text", "mode", "levels"),
    [
        (
            "[operator]\nleft = 'rtsp://anna:s3cret@127.0.0.1:1/x'\nright = '/dev/video98'\nrig = 'absent'\n",
            0o644,
            ["warning"],
        ),
        ("[operator]\nleft = 'rtsp://anna:s3cret@127.0.0.1:1/x'\nright = '/dev/video98'\nrig = 'absent'\n", 0o640, []),
        ("[operator]\nleft = '/dev/video97'\nright = '/dev/video98'\nrig = 'absent'\n", 0o644, []),
        ("[[video.cameras]]\nname = 'front'\nsource = 'rtsp://127.0.0.1:1/x?password=s3cret'\n", 0o644, ["warning"]),
    ],
)
def test_a_cameras_password_that_everybody_can_read_is_found(
    tmp_path: Path, text: str, mode: int, levels: list[str]
) -> None:
    path = tmp_path / "site.toml"
    path.write_text(text)
    path.chmod(mode)
    found = [finding for finding in examine(path, ()) if finding.check == "camera's password"]
    assert [finding.level for finding in found] == levels
    assert not any("s3cret" in str(finding) for finding in found)


@pytest.mark.slow
def test_a_real_run_ends_by_its_worst_finding(tmp_path: Path) -> None:
    config = tmp_path / "local.toml"
    listen, remote = free_ports(2)
    links = f'[links]\nlisten = "tcp/127.0.0.1:{listen}"\nremote = "tcp/127.0.0.1:{remote}"\n'
    config.write_text(links + '[operator]\nleft = "/dev/video97"\nright = "/dev/video98"\nrig = "absent.json"\n')
    command = [sys.executable, "-m", "farhand", "doctor", "--config", str(config), "--json"]
    done = subprocess.run(command, check=False, capture_output=True, text=True, timeout=60)
    told = json.loads(done.stdout)
    levels = {finding["check"]: finding["level"] for finding in told["findings"]}
    assert levels["calibration"] == levels["camera left"] == levels["camera right"] == "error"
    assert levels["port local"] == levels["configuration"] == "ok"
    assert levels["clocks"] == "warning"
    assert {"python", "real time", "congestion", "disk", "shared memory", "compiled code"} <= levels.keys()
    assert (done.returncode, told["worst"]) == (1, "error")


@pytest.mark.slow
def test_warnings_alone_are_no_failure(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("farhand.doctor.site.CLOCK_TIMEOUT_NS", 200 * NS_PER_MS)
    listen, remote = free_ports(2)
    ports = (f"links.listen=tcp/127.0.0.1:{listen}", f"links.remote=tcp/127.0.0.1:{remote}")
    config = Path(__file__).parents[3] / "farhand/deployment/sites/local.toml"
    done = CliRunner().invoke(app, ["doctor", "--config", str(config), *options_of(ports)])
    assert done.exit_code == 0, done.output
    assert "warning  clocks: the remote site does not answer" in done.output


def test_every_mistake_of_the_configuration_is_a_finding(tmp_path: Path) -> None:
    config = tmp_path / "remote.toml"
    config.write_text("[driver]\nnme = 1\n[safety]\nt_soft_ms = 1.0\n")
    done = CliRunner().invoke(app, ["doctor", "--config", str(config)])
    assert done.exit_code == 1
    assert "error    configuration: " in done.output
    assert "did you mean name?" in done.output
    assert "t_soft_ms" in done.output


def test_a_file_that_is_not_there_is_not_to_be_corrected_in_a_line(tmp_path: Path) -> None:
    missing = tmp_path / "missing.toml"
    for options in ((), ("--link",)):
        done = CliRunner().invoke(app, ["doctor", "--config", str(missing), *options])
        assert done.exit_code == 1
        assert f"error    configuration: cannot read {missing}: No such file" in done.output
        assert "cure: give the path of a file that is there" in done.output
        assert "correct that line" not in done.output


@pytest.mark.slow
@pytest.mark.parametrize(
    ("setting", "found"),
    [
        ("robot.model=/none.urdf", "error    robot: robot.model '/none.urdf' is neither a built-in model"),
        ("robot.model=arm.urdf", f"there is no {Path.cwd() / 'arm.urdf'}; put it there, or give its path"),
        ("robot.tool_frame=hook", "error    robot: "),
        ("robot.speed=0.5", "ok       robot: the model a465 loads"),
        ("robot.start_deg=[0, 0, 500, 0, 0, 0]", "error    start posture: robot.start_deg: joint_3"),
        ("robot.speed=1", "ok       stopping: a stop takes 334 ms at most (joint_1), of 600 allowed"),
        ("robot.speed=0.9", "ok       guard: not guarded: people, cables"),
        (
            "robot.capsules=[]",
            "warning  guard: not guarded: the tool (robot.capsules is empty); links without a shape: wrist_yaw; people",
        ),
        (
            "safety.workspace_max_m=[1000,1000,1000]",
            "error    workspace: safety.workspace_min_m and _max_m: the box is",
        ),
        ("safety.t_latch_ms=1001", "error    configuration: "),
        ("robot.jerk_rad_s3=1", "error    stopping: joint_1 may take 7090 ms to stop"),
        ("robot.jerk_rad_s3=1001", "error    limits: robot.jerk_rad_s3: 1001 for joint_1 is above the arm's own 1000"),
        ("robot.stance.elbow=backward", "error    kinematics: robot.stance.elbow"),
        ("driver.name=elbow", "error    driver: there is no driver 'elbow'; choose one of"),
    ],
)
def test_the_robots_side_is_loaded_as_the_remote_site_would(setting: str, found: str) -> None:
    config = Path(__file__).parents[3] / "farhand/deployment/sites/remote.toml"
    done = CliRunner().invoke(app, ["doctor", "--config", str(config), "--set", setting])
    assert found in done.output
    assert done.exit_code == int(found.startswith(("error", "there is no")))


@pytest.mark.slow
def test_an_arm_whose_file_states_no_jerk_is_said_to_have_none(tmp_path: Path) -> None:
    urdf = tmp_path / "arm.urdf"
    urdf.write_text(RobotConfig().urdf.read_text().replace(' jerk="1000"', ""))
    (found,) = (finding for finding in examine(None, (f"robot.model={urdf}",)) if finding.check == "stopping")
    assert found.level == "warning"
    assert f"{urdf} states no jerk for joint_1, joint_2" in found.sentence
    assert "100 rad/s³ counts; a stop takes 548 ms at most (joint_5)" in found.sentence


@pytest.mark.slow
@pytest.mark.parametrize(
    ("setting", "wrong"),
    [("driver.name=kinematic", 0), ("tracking.method=markers", 0), ("metrics.port=-1", 2), ("drivr.name=x", 2)],
)
def test_a_setting_without_a_file_goes_to_the_site_that_knows_it(
    setting: str, wrong: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("farhand.doctor.site.CLOCK_TIMEOUT_NS", 200 * NS_PER_MS)
    found = [finding for finding in examine(None, (setting,)) if finding.check == "configuration"]
    assert [finding.level for finding in found].count(Severity.ERROR) == wrong, found


@pytest.mark.slow
@pytest.mark.parametrize(
    ("setting", "found"),
    [
        ("driver.emulate=false", "the franka driver needs the robot's address: set driver.options.host"),
        ("driver.options.hots=172.16.0.2", "driver.options.hots: is not a key here; did you mean host?"),
        ("robot.acceleration_rad_s2=[9]", "the acceleration of fr3_joint1 is 9, and more than 6 rad/s² leaves no room"),
    ],
)
def test_what_a_driver_checks_itself_is_a_finding(setting: str, found: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("remote_site.drivers.listing.find_spec", lambda name: name)  # nothing of a robot is used
    done = CliRunner().invoke(app, ["doctor", "--config", str(DRIVER_FILES[FRANKA]), "--set", setting])
    assert f"error    driver: {found}" in done.output
    assert done.exit_code == 1


def test_a_driver_whose_package_is_missing_is_a_finding_with_its_cure(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("remote_site.drivers.listing.find_spec", lambda _: None)
    done = CliRunner().invoke(app, ["doctor", "--config", str(DRIVER_FILES[FRANKA])])
    assert "error    driver: pylibfranka is not installed" in done.output
    assert "pip install 'farhand[franka]'" in done.output
