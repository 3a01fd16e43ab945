"""`farhand config check` finds all that is wrong at once, of keys, values, tables and the arm."""

import json
import re
from collections.abc import Callable
from pathlib import Path

import pytest
from typer.testing import CliRunner, Result

from farhand.cli import app
from farhand.deployment.shipped import HERE
from remote_site.drivers.config import DRIVER_FILES, FRANKA

SITES = HERE / "sites"


@pytest.fixture
def check(tmp_path: Path) -> Callable[[str], Result]:
    """Checks a file of this text."""

    def run(text: str) -> Result:
        file = tmp_path / "site.toml"
        file.write_text(text)
        return CliRunner().invoke(app, ["config", "check", str(file)])

    return run


def test_the_shipped_files_have_no_mistake_and_each_is_named_with_its_command() -> None:
    files = [str(path) for path in sorted(SITES.glob("*.toml"))]
    done = CliRunner().invoke(app, ["config", "check", *files])
    assert done.exit_code == 0, done.output
    assert f"no mistake; for this file: farhand router --config {SITES / 'router.toml'}" in done.output
    assert len(done.output.splitlines()) == len(files)


def test_what_would_come_in_a_second_round_comes_in_the_first(check: Callable[[str], Result]) -> None:
    done = check(
        "[robot]\nstart_deg = [0.0, 1.0]\nspeed = 'fast'\n[safety]\nt_soft_ms = 400\nt_latch_ms = 100\n"
        "[video]\nfsp = 30\n[driver]\nnmae = 'kinematic'\n"
    )
    assert done.exit_code == 1
    lines = done.output.splitlines()
    for words in ("robot.speed: 'fast' is not allowed", "start_deg", "t_latch_ms", "did you mean fps?", "mean name?"):
        assert [line for line in lines if words in line], (words, lines)


def test_an_arm_is_not_judged_where_its_model_is_a_mistake(check: Callable[[str], Result]) -> None:
    done = check("[robot]\nmodel = 7\nstart_deg = [0.0, 1.0]\n")
    assert len(done.output.splitlines()) == 1
    assert "robot.model: 7 is not allowed: give words in quotes, not a whole number" in done.output


def test_what_is_wrong_between_tables_is_said_once(check: Callable[[str], Result]) -> None:
    (line,) = check("[simulation]\ntextured = true\n").output.splitlines()
    assert 'needs tracking.method = "monocular"' in line


def test_an_empty_file_is_told_as_such(check: Callable[[str], Result]) -> None:
    (line,) = check("# nothing yet\n").output.splitlines()
    assert line.endswith("site.toml: empty, so that every default counts; to begin one: farhand config show remote")


def test_each_file_has_its_own_answer(tmp_path: Path) -> None:
    broken = tmp_path / "broken.toml"
    broken.write_text("[links]\nremote = \n")
    done = CliRunner().invoke(
        app, ["config", "check", str(SITES / "local.toml"), str(broken), str(tmp_path / "none"), "--json"]
    )
    assert done.exit_code == 1
    fine, not_toml, absent = json.loads(done.output)["files"]
    assert (fine["command"], fine["mistakes"]) == ("local", [])
    assert not_toml["mistakes"][0].startswith(f"{broken}:2: not valid TOML")
    assert absent["mistakes"][0].startswith(f"cannot read {tmp_path / 'none'}: No such file")


CERTIFICATES = 'ca = "a"\ncertificate = "b"\nkey = "c"\n'
BEYOND = "plain tcp beyond this host"


@pytest.mark.parametrize(
    ("text", "line", "words"),
    [
        ('[driver]\nname = "kinematic"\noptions = { foo = 1 }\n', 3, "driver.options.foo: this driver has no options"),
        ('[driver]\nname = "simulated"\n[driver.options]\nfoo = 1\n', 4, "driver.options.foo: this driver has no"),
        ('[driver]\nname = "c500c"\n[driver.options]\nport = "x"\nprot = 1\n', 5, "driver.options.prot: is not a key"),
        ('[driver]\ncommand_timeout_ms = 99\nname = "kinematik"\n', 3, "'kinematik'; did you mean kinematic?"),
        ('[grip]\n[driver]\nname = "franka"\n', 2, "set driver.options.host"),
        ('cell = "A"\n[robot]\n', 1, "cell: 'A': use 1 to 32 small letters"),
        ("[robot]\nspeed = 0.5\nstart_deg = [0.0]\n", 3, "robot.start_deg has 1 angles for 6 joints"),
        ("[grip]\n[robot]\nacceleration_rad_s2 = [1.0, 1.0]\n", 3, "robot.acceleration_rad_s2 has 2 values"),
        ("[robot]\njerk_rad_s3 = 1.0\n", 2, "may take"),
        ('[robot]\ntool_frame = "hook"\n', 2, "no frame 'hook'"),
        ("[mapping]\nscale_range = [1.5, 2.0]\n", 2, "scale: 1 must be within"),
        ('[engagement]\nmode = "automatic"\n[driver]\nname = "c500c"\n', 2, "engagement.mode = 'automatic' lets"),
        ('[[assist.targets]]\nname = "a"\nkind = "grasp"\nmarker = 1\nsize_mm = 40.0\n', 1, "assist"),
        (
            '[links]\nvideo = "tcp/0.0.0.0:7448"\ncontrol = "tcp/0.0.0.0:7447"\n',
            3,
            f"links.control: endpoint .*{BEYOND}",
        ),
        ('[links]\nvideo = "tcp/0.0.0.0:7448"\n', 2, f"links.video: endpoint .*{BEYOND}"),
        ('[links]\nrouter = "tcp/0.0.0.0:7450"\ncontrol = "nowhere"\n', 2, f"links.router: endpoint .*{BEYOND}"),
        ('[robot]\n[links]\nvideo = "tcp/127.0.0.1:7447"\n', 3, "links.video: port 7447 is taken by links.control"),
        ("[robot]\n[metrics]\nport = 7447\n", 3, "metrics.port: port 7447 is taken by links.control"),
        (f'[robot]\n[links]\nvideo = "quic/a:1"\n[links.tls]\n{CERTIFICATES}', 3, "links.video: .* cannot be bounded"),
        (f'[links]\nviewers.listen = "tls/a"\n[links.viewers.tls]\n{CERTIFICATES}[robot]\n', 2, "viewers.listen: end"),
        ('[links]\nremote = "tcp/robot:7447"\n[tracking]\n', 2, f"links.remote: endpoint .*{BEYOND}"),
        ('[links]\nlisten = "tls/127.0.0.1:7457"\n[tracking]\n', 2, "links.listen: .* tls needs certificates"),
        ("[tracking]\n[metrics]\nport = 7457\n", 3, "metrics.port: port 7457 is taken by links.listen"),
        ('[operator]\nleft = "/a"\nright = "/a"\nrig = "r"\n', 1, "cameras left and right: /a and /a are the same"),
        ('[operator]\nalone = true\nleft = "/a"\nrig = "r"\n', 2, "needs tracking.method"),
        ("[simulation]\nseed = 2\ntextured = true\n", 3, "needs tracking.method"),
        ("[tracking]\n[simulation.motion]\nwrist = [0.0, 0.0, 0.0]\n", 2, "the simulated arm cannot reach"),
        ("[tracking]\n[simulation.stereo]\nfocal_px = 20000\n", 2, "cannot give a calibration"),
        ('[tracking]\nmethod = "marker"\n', 2, "method: 'marker' is not allowed: did you mean markers?"),
        ('[serve]\nport = 8470\n[links]\nlocal = "tcp/desk:7457"\n', 4, f"links.local: endpoint .*{BEYOND}"),
        ("[serve]\nport = 1979-05-27\n", 2, "1979-05-27 is not allowed: give a whole number, not a date"),
        ('listen = ["tcp/127.0.0.1:7450", "tcp/0.0.0.0:7451"]\n', 1, f"listen: endpoint .*{BEYOND}"),
        ('cell = "a"\nlisten = ["tcp/127.0.0.1:7450", "tcp/localhost:0"]\n', 2, "a port from 1 to 65535"),
        ('listen = ["tcp/127.0.0.1:7450"]\noperators = ["Anna Meier"]\n', 2, "operators: 'Anna Meier': use"),
    ],
)
def test_what_the_start_would_refuse_is_said_with_its_line(
    text: str, line: int, words: str, check: Callable[[str], Result]
) -> None:
    done = check(text)
    assert done.exit_code == 1
    assert re.search(rf"site\.toml:{line}: .*{words}", done.output), done.output


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ('[links]\ncontrol = "tls/a:1"\n[links.tls]\nca = "a"\n[robot]\n', "give all three, or none"),
        ("[operator]\nleft = '/a'\nright = '/a'\n", "rig is missing"),
    ],
)
def test_what_only_follows_from_a_mistake_is_not_said(text: str, words: str, check: Callable[[str], Result]) -> None:
    (line,) = check(text).output.splitlines()
    assert words in line


def test_an_arms_file_that_is_completed_by_hand_says_what_it_lacks_and_where(tmp_path: Path) -> None:
    shipped = DRIVER_FILES[FRANKA]
    done = CliRunner().invoke(app, ["config", "check", str(shipped)])
    number = shipped.read_text().splitlines().index("[driver]") + 1
    assert f"{shipped}:{number}: the franka driver needs the robot's address: set driver.options.host" in done.output
    copied = tmp_path / "fr3.toml"
    copied.write_text(shipped.read_text().replace("# options.host", "options.host"))
    done = CliRunner().invoke(app, ["config", "check", str(copied)])
    assert "options.host" not in done.output
