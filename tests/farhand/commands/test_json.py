"""Every command that prints a result prints it as JSON too, with the keys that docs/json.md names."""

import json
import re
from collections.abc import Callable
from pathlib import Path

import pytest
from typer.testing import CliRunner, Result

from farhand.cli import app
from tests.farhand.commands.json_plays import PLAYS, REPLIED, Play
from tests.farhand.commands.parser_walk import options_of, walk

DOCUMENT = Path(__file__).parents[3] / "docs/json.md"
NO_RESULT = {
    "local": "runs until it is stopped",
    "remote": "runs until it is stopped",
    "console": "runs until it is stopped",
    "router": "runs until it is stopped, or prints what zenohd reads",
    "teach run": "runs until it is stopped",
    "setup": "asks a person",
}
LEAVES = {" ".join(words): command for words, command in walk() if not getattr(command, "commands", {})}


def documented() -> dict[str, set[str]]:
    """The keys of each command's result, by the table of the document: what is in brackets is within them."""
    found: dict[str, set[str]] = {}
    for line in DOCUMENT.read_text(encoding="utf-8").splitlines():
        if line.startswith("| `"):
            commands, keys = line.strip("| ").split(" | ", 1)
            optional = keys.partition("; with `--record` also ")[0]
            outer = re.sub(r"\([^)]*\)|: a list of .*|`--\w+`", "", optional)
            found |= {name: set(re.findall(r"`(\w+)`", outer)) for name in re.findall(r"`([^`]+)`", commands)}
    return found


@pytest.fixture
def play(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Callable[..., Result]:
    """Runs a command's play in an empty folder."""
    monkeypatch.chdir(tmp_path)

    def run(name: str, played: Play, *more: str) -> Result:
        played.prepare()
        for words in played.before:
            assert CliRunner().invoke(app, words).exit_code == 0
        for target, stand_in in played.instead.items():
            monkeypatch.setattr(target, stand_in)
        return CliRunner().invoke(app, [*name.split(), *played.arguments, *more])

    return run


def test_no_command_forgets_it() -> None:
    with_json = {name for name, command in LEAVES.items() if "--json" in options_of(command)}
    assert set(LEAVES) - with_json == set(NO_RESULT)
    assert with_json == set(PLAYS)
    assert with_json == set(documented())


@pytest.mark.slow
@pytest.mark.parametrize("name", PLAYS)
def test_a_result_is_one_json_object_with_the_documented_keys(name: str, play: Callable[..., Result]) -> None:
    done = play(name, PLAYS[name], "--json")
    assert done.exit_code == PLAYS[name].code, done.exception
    assert done.stdout.isascii()
    assert set(json.loads(done.stdout)) == documented()[name]


def test_what_a_site_says_is_kept_whole_and_does_nothing_to_a_terminal(play: Callable[..., Result]) -> None:
    done = play("reset", PLAYS["reset"], "--json")
    assert json.loads(done.stdout) == {"done": True, "reason": REPLIED}
    assert "\x1b" not in done.output
    assert done.stderr == "to reset: fault\n"
    assert play("reset", PLAYS["reset"]).stdout == "to reset: fault\nthe arm follows \\x1b[31mthe hand\n"


def test_limits_and_way_points_are_numbers(play: Callable[..., Result]) -> None:
    limits = json.loads(play("limits", PLAYS["limits"], "--json").stdout)
    assert limits["limits"]["jerk_rad_s3"]["values"] == [1000.0] * len(limits["joints"])
    assert limits["ages"][0]["age_ms"] == 100.0
    shown = json.loads(play("teach show", PLAYS["teach show"], "--json").stdout)
    assert [point["at_s"] for point in shown["way_points"]] == sorted(point["at_s"] for point in shown["way_points"])


def test_a_replay_on_the_page_has_no_result(play: Callable[..., Result]) -> None:
    done = play("replay", Play(["a.mcap"]), "--json")
    assert "--json is the verdict of --verify" in str(done.exception)
