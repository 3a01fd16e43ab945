"""What bash completes after `farhand`, by the script that --install-completion writes."""

import os
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
import typer

from farhand.cli import app
from farhand.commands.completion import arm_names, experiment_names, motion_names, setting_keys

PROGRAM = "#!{python}\nimport sys\nsys.path[:0] = {path!r}\nfrom farhand.__main__ import main\nmain()\n"
COMPLETE = """
source "$1"; shift
COMP_WORDS=("$@") COMP_CWORD=$(($# - 1))
_farhand_completion farhand
printf '%s\\n' "${COMPREPLY[@]}"
"""


@pytest.fixture
def completed(tmp_path: Path) -> Callable[..., list[str]]:
    """What bash offers for the last of these words."""
    if shutil.which("bash") is None:
        pytest.skip("no bash here")
    program, script = tmp_path / "farhand", tmp_path / "farhand.sh"
    program.write_text(PROGRAM.format(python=sys.executable, path=[path for path in sys.path if path]))
    program.chmod(0o755)
    environment = os.environ | {"PATH": f"{tmp_path}:{os.environ['PATH']}"}
    source = environment | {"_FARHAND_COMPLETE": "source_bash"}
    told = subprocess.run(["farhand"], check=True, capture_output=True, text=True, env=source, timeout=60)
    script.write_text(told.stdout)

    def complete(*words: str) -> list[str]:
        command = ["bash", "--norc", "-c", COMPLETE, "bash", str(script), "farhand", *words]
        done = subprocess.run(command, check=True, capture_output=True, text=True, env=environment, timeout=60)
        return done.stdout.split()

    return complete


@pytest.mark.slow
def test_commands_options_and_choices_are_completed(completed: Callable[..., list[str]]) -> None:
    assert completed("sta") == ["status"]
    assert completed("maintenance", "") == ["stop", "reset"]
    assert {"--config", "--set", "--save-views"} <= set(completed("local", "--"))
    assert completed("track", "--tracker", "m") == ["markers", "monocular"]


@pytest.mark.slow
def test_names_and_keys_are_completed_and_files_are_left_to_the_shell(completed: Callable[..., list[str]]) -> None:
    assert completed("config", "show", "remote-") == ["remote-assist", "remote-thesis"]
    assert completed("loopback", "--driver", "k") == ["kinematic"]
    assert completed("remote", "--set", "robot.limits") == ["robot.limits_factor="]
    assert completed("local", "--config", "loc") == []


@pytest.mark.parametrize(
    ("words", "incomplete", "keys", "others"),
    [
        ("remote", "safety.t_", {"safety.t_soft_ms=", "safety.t_latch_ms="}, set()),
        ("local", "", {"simulation.motion.name=", "operator.left="}, {"robot.speed="}),
        ("loopback", "", {"simulation.motion.name=", "robot.speed="}, {"serve.port="}),
        ("teach run", "", {"operator.left="}, {"robot.speed="}),
        ("driver test", "dr", {"driver.name="}, {"drift.misfit_sigmas="}),
        ("console", "serve.p", {"serve.port="}, set()),
        ("router", "list", {"listen="}, set()),
    ],
)
def test_a_command_completes_the_keys_of_the_sites_whose_settings_it_takes(
    words: str, incomplete: str, keys: set[str], others: set[str]
) -> None:
    context = typer.Context(typer.main.get_command(app), info_name=f"farhand {words}")
    found = set(setting_keys(context, incomplete))
    assert keys <= found
    assert not others & found
    assert all(key.startswith(incomplete) for key in found)


def test_motions_arms_and_experiments_are_those_that_there_are() -> None:
    assert motion_names("rotate") == ["rotate_x", "rotate_y", "rotate_z"]
    assert arm_names("f") == ["fr3"]
    assert experiment_names("a") == ["all"]


def test_run_as_a_module_it_writes_the_same_script() -> None:
    # The shell is found among the parents, so bash has to stay: with one command alone it would become that.
    command = ["bash", "-c", f'"{sys.executable}" -m farhand --show-completion; exit $?']
    told = subprocess.run(command, capture_output=True, text=True, check=True)
    assert "_farhand_completion()" in told.stdout
