"""`farhand config check` finds all that is wrong at once, of keys, values, tables and the arm."""

import json
from collections.abc import Callable
from pathlib import Path

import pytest
from typer.testing import CliRunner, Result

from farhand.cli import app
from farhand.deployment.shipped import HERE

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
