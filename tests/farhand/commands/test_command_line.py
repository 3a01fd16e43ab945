"""The command line as a user meets it: exit codes, and errors that name the cure without a traceback."""

import errno
import os
import socket
import subprocess
import sys
from collections.abc import Callable, Iterator
from importlib.metadata import version
from pathlib import Path

import pytest
import structlog

from common.clock import NS_PER_MS
from farhand.__main__ import main as start
from farhand.cli import main
from farhand.deployment.shipped import HERE
from farhand.teach.writing import as_toml
from local_site.calibration.rig_file import save_rig
from local_site.simulation.cameras import control_point_rows, exact_rig
from local_site.simulation.config import SimulationConfig
from remote_site.runtime.crash_marker import CrashMarker
from tests.farhand.teach.example_task import TASK

SITES = HERE / "sites"
Here = Callable[..., subprocess.CompletedProcess[str]]


def farhand(*arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "farhand", *arguments], check=False, capture_output=True, text=True, timeout=60
    )


@pytest.fixture
def here(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path) -> Iterator[Here]:
    """Runs a command in this process, which is quicker, and returns how it ended: no exit has a traceback."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("common.link.request_client.PATIENCE_NS", 300 * NS_PER_MS)

    def run(*arguments: str) -> subprocess.CompletedProcess[str]:
        monkeypatch.setattr(sys, "argv", ["farhand", *arguments])
        with pytest.raises(SystemExit) as ended:
            main()
        told = capsys.readouterr()
        assert isinstance(ended.value.code, int)
        return subprocess.CompletedProcess(arguments, ended.value.code, told.out, told.err)

    yield run
    assert not list(tmp_path.glob("never*")), "what is refused leaves nothing behind"
    structlog.reset_defaults()


@pytest.mark.parametrize(
    ("arguments", "code", "words"),
    [
        (["remote", "--set", "driver.nme=x"], 2, "did you mean name?"),
        (["remote", "--set", "safety.t_latch_ms=50"], 2, ">= 100"),
        (["remote", "--set", "safety.t_latch_ms=1001"], 2, "<= 1000"),
        (["remote", "--config", "absent.toml"], 2, "absent.toml"),
        (["local", "--set", "operator.left=0"], 2, "both be simulated, or neither"),
        (["loopback", "--motion", "dance"], 2, "pick_and_place"),
        (["engage", "--cell", "No Such"], 2, "small letters"),
        (["engage", "--operator", "No One"], 2, "operator 'No One': use"),
        (["local", "--set", "authority.operator=Anna Meier"], 2, "small letters"),
        (["remote", "--set", "engagement.mode=button"], 2, "button"),
        (["engage", "--config", str(SITES / "local.toml")], 2, "farhand local --config"),
        (["local", "--config", str(SITES / "remote.toml")], 2, "is a file of the remote site"),
        (
            ["stop", "--remote", "tcp/127.0.0.1:9"],
            1,
            "STOP NOT ACKNOWLEDGED: the arm may still move, use the",
        ),
        (["stop", "--operator", "No One"], 2, "use the emergency stop. operator 'No One'"),
        (
            ["stop", "--config", "absent.toml"],
            2,
            "use the emergency stop. cannot read absent.toml: No such",
        ),
        (
            ["calibrate", "points", "absent.csv"],
            1,
            "absent.csv: No such file or directory; give the path of a CSV",
        ),
        (["calibrate", "points", sys.executable], 1, "is not UTF-8 text; save it as CSV in UTF-8"),
        (["teach", "show", "absent.toml"], 2, "farhand: cannot read absent.toml: No such file or directory; give the"),
        (
            ["limits", "--config", "."],
            2,
            "farhand: cannot read .: Is a directory; give the path of a file",
        ),
        (["router", "--config", str(SITES / "router.toml")], 2, "farhand: tls.ca: cannot read /etc/farhand/ca.pem"),
        (["router", "--config", str(SITES / "router.toml")], 2, "or make the certificates on the host that keeps"),
        (["calibrate", "latency", "--left", "/dev/video97"], 1, "camera left: cannot open /dev/video97"),
        (["track", "--rig", "absent.json", "--left", "a", "--right", "b"], 1, "absent.json"),
        (["remote", "--emulate"], 2, "driver.emulate is for the drivers c500c, franka; simulated has no emulator"),
        (["experiment", "dance", "--out", "never"], 2, "choose one of: all, calibration"),
        (["console", "--set", "serve.host=0.0.0.0"], 2, "needs token, certificate and key"),
        (["remote", "--set", "links.tls.ca=ca.pem"], 2, "give all three, or none"),
        (["remote", "--set", "links.plain_text_beyond_loopback=yes"], 2, "anybody on this network can move the arm"),
        (["certificates", "create", "No Such", "--dir", "never"], 2, "small letters"),
        (["certificates", "create", "lab", "--dir", "never", "--host", "a b"], 2, "host name or an address"),
        (["certificates", "renew", "lab", "--dir", "never"], 2, "farhand certificates create lab"),
        (["dance"], 2, "No such command"),
        (["track"], 2, "Missing option"),
        (["remote", "--set", "robot.model=/none.urdf"], 2, "neither a built-in model"),
        (["remote", "--set", "robot.tool_frame=hook"], 2, "set robot.tool_frame to one of"),
        (["remote", "--set", "safety.collision.ignored_pairs=[['hook', 'table']]"], 2, "ignored_pairs: no hook"),
        (["remote", "--set", "driver.name=elbow"], 2, "choose one of: c500c, franka, kinematic, simulated"),
        (["remote", "--set", "links.control=tcp/10.0.0.1:7447"], 2, "refused"),
        (["loopback", "--driver", "none"], 2, "choose one of"),
        (["loopback", "--set", "driver.nme=x"], 2, "did you mean name?"),
        (["loopback", "--config", "absent.toml"], 2, "absent.toml"),
        (["config", "show", "remot"], 2, "choose one of: console, local, local-cameras, local-thesis, remote"),
        (["driver", "test", "elbow"], 2, "choose one of"),
        (["driver", "test", "kinematic", "--set", "robot.model=/none.urdf"], 2, "neither a built-in model"),
        (["limits", "--set", "robot.model=/none.urdf"], 2, "neither a built-in model"),
        (["limits", "--set", "robot.jerk_rad_s3=1"], 2, "joint_1 may take 7090 ms to stop"),
        (["remote", "--driver", "c500c"], 2, "set driver.options.port, or start with --emulate"),
        (["remote", "--driver", "franka", "--set", "driver.options.hots=x"], 2, "did you mean host?"),
        (["doctor", "--set", "driver.name=elbow"], 1, ""),
        (["arm", "import", "absent.urdf"], 1, "cannot read absent.urdf"),
        (["arm", "import", "absent.urdf", "--lock", "joint"], 2, "write it as JOINT=POSITION"),
        (["arm", "import", "absent.urdf", "--lock", "joint=nan"], 2, "write it as JOINT=POSITION"),
        (["console", "--set", "links.control=tcp/10.0.0.1:7447"], 2, "refused"),
    ],
)
def test_misuse_is_told_with_its_cure(arguments: list[str], code: int, words: str, here: Here) -> None:
    done = here(*arguments)
    assert done.returncode == code, done.stderr
    assert words in " ".join(done.stderr.split())


def test_the_version_is_printed_with_the_name(here: Here) -> None:
    done = here("--version")
    assert (done.returncode, done.stdout) == (0, f"farhand {version('farhand')}\n")


def test_the_drivers_are_listed_with_where_they_come_from(here: Here) -> None:
    done = here("driver", "list")
    assert done.returncode == 0
    own = {line.partition(" ")[0]: line for line in done.stdout.splitlines()}
    assert own.keys() >= {"c500c", "kinematic", "simulated"}
    assert own["kinematic"].startswith("kinematic (ships with farhand ")


def test_one_certificate_has_one_key(here: Here) -> None:
    certificates = ["certificates", "create", "lab", "--operator", "anna"]
    assert here(*certificates).returncode == 0
    one, two = here("certificates", "operator", "lab", "ben"), here("certificates", "operator", "lab", "carl", "dora")
    assert ", and its key\nname ben in links.operators" in one.stdout
    assert ", and their keys\nname carl and dora in links.operators" in two.stdout


@pytest.mark.slow
@pytest.mark.parametrize("command", [["--help"], ["config", "show", "remote"], ["config", "init", "sites"]])
def test_a_full_disk_ends_a_command_without_a_traceback(command: list[str], tmp_path: Path) -> None:
    with Path("/dev/full").open("w") as full:
        done = subprocess.run(
            [sys.executable, "-m", "farhand", *command],
            check=False,
            stdout=full,
            stderr=subprocess.PIPE,
            text=True,
            timeout=60,
            cwd=tmp_path,
        )
    assert done.returncode == 1
    assert done.stderr == "farhand: no space is left to write to; free some, or write elsewhere\n"


@pytest.mark.parametrize("number", [errno.ENOSPC, errno.EDQUOT])
def test_a_full_disk_is_named_by_the_file_where_that_is_known(
    number: int, here: Here, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(*_: object, **__: object) -> None:
        raise OSError(number, os.strerror(number), "/disk/report.html")

    monkeypatch.setattr("farhand.cli.app", full)
    done = here("config", "show", "remote")
    assert done.returncode == 1
    assert done.stderr == "farhand: no space is left to write to /disk/report.html; free some, or write elsewhere\n"


@pytest.mark.parametrize(("site", "key"), [("local", "links.listen"), ("remote", "links.video")])
def test_a_site_whose_port_is_taken_says_so(site: str, key: str, here: Here) -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        done = here(site, "--set", f"{key}=tcp/127.0.0.1:{taken.getsockname()[1]}")
    assert done.returncode == 1
    assert f"(process {os.getpid()}) has this port" in done.stderr


def test_a_console_whose_port_is_taken_says_so_once(here: Here) -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        done = here("console", "--set", f"serve.port={taken.getsockname()[1]}")
    assert done.returncode == 1
    assert done.stderr.count(f"process {os.getpid()}") == 1


def test_a_taught_run_beside_a_local_site_says_what_to_stop(here: Here, tmp_path: Path) -> None:
    (tmp_path / "task.toml").write_text(as_toml(TASK))
    with socket.create_server(("127.0.0.1", 0)) as taken:
        done = here("teach", "run", "task.toml", "--set", f"links.listen=tcp/127.0.0.1:{taken.getsockname()[1]}")
    assert done.returncode == 1
    assert "Stop 'farhand local' on this host: this takes its place" in done.stderr


def test_the_command_line_loads_nothing_of_what_it_runs() -> None:
    heavy = "cv2", "mujoco", "numba", "numpy", "pinocchio", "scipy", "starlette", "zenoh"
    program = f"import sys, farhand.cli; print([name for name in {heavy!r} if name in sys.modules])"
    done = subprocess.run([sys.executable, "-c", program], check=True, capture_output=True, text=True)
    assert done.stdout == "[]\n"


def test_ctrl_c_before_anything_listens_to_it_ends_without_a_traceback(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def interrupted() -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("farhand.__main__.catch_signals", lambda: None)  # for this process, the handlers stay
    monkeypatch.setattr("farhand.cli.main", interrupted)
    with pytest.raises(SystemExit) as ended:
        start()
    assert ended.value.code == 130
    assert capsys.readouterr().err == "farhand: interrupted\n"


@pytest.mark.slow
def test_a_start_that_fails_leaves_the_marker_of_an_unfinished_run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("STATE_DIRECTORY", str(tmp_path))
    marker = CrashMarker("cell")
    port = ["--set", "driver.options.port=/dev/none"]
    failed = farhand("remote", "--driver", "c500c", *port, "--set", "links.control=tcp/127.0.0.1:7999")
    assert failed.returncode == 1
    assert "cannot open the serial line /dev/none" in failed.stderr
    assert "Traceback" not in failed.stderr
    assert marker.set()


def with_cameras(rig: Path) -> list[str]:
    """A local site with cameras that are not there; its tracker needs no preparation."""
    settings = ["operator.left=/dev/video97", "operator.right=/dev/video98", f"operator.rig={rig}"]
    return ["local", *(part for s in (*settings, "tracking.method=markers") for part in ("--set", s))]


@pytest.mark.slow
def test_a_missing_camera_is_told(tmp_path: Path, here: Here) -> None:
    csv, rig = tmp_path / "points.csv", tmp_path / "rig.json"
    csv.write_text("\n".join(control_point_rows(SimulationConfig().stereo, 0.3, 1)) + "\n")
    calibrated = here("calibrate", "points", str(csv), "--out", str(rig))
    assert calibrated.returncode == 0
    assert "reprojection rms: left 0." in calibrated.stdout
    assert "total" in calibrated.stdout
    done = farhand(*with_cameras(rig))
    assert done.returncode == 1
    assert "camera left: cannot open /dev/video97" in done.stderr
    assert "Traceback" not in done.stderr


def test_more_cameras_than_the_rig_has_are_refused(tmp_path: Path, here: Here) -> None:
    rig = tmp_path / "rig.json"
    save_rig(exact_rig(SimulationConfig().stereo), rig)
    done = here("track", "--rig", str(rig), "--left", "a", "--right", "b", "--also", "c")
    assert done.returncode == 1
    assert "the rig has 2 cameras (left, right), but 3 are given" in done.stderr


def test_a_rig_that_is_none_is_told(tmp_path: Path, here: Here) -> None:
    rig = tmp_path / "rig.json"
    rig.write_text("{}")
    done = here(*with_cameras(rig))
    assert done.returncode == 1
    assert "farhand calibrate points" in done.stderr


def test_a_calibration_file_with_a_nonsense_point_is_refused_by_its_line(tmp_path: Path, here: Here) -> None:
    csv = tmp_path / "points.csv"
    csv.write_text("X_mm,Y_mm,Z_mm,uL_px,vL_px,uR_px,vR_px\n0,0,0,1,2,3,4\n0,0,banana,1,2,3,4\n0,0,1,inf,2,3,4\n")
    out = tmp_path / "rig.json"
    done = here("calibrate", "points", str(csv), "--out", str(out))
    assert done.returncode == 1
    assert "3" in done.stderr
    assert "banana" in done.stderr
    assert "4" in done.stderr
    assert "Traceback" not in done.stderr
    assert not out.exists()
