"""What bash completes after `farhand`, by the script that --install-completion writes."""

import os
import pty
import select
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
import typer

from farhand.cli import app
from farhand.commands.bash_words import joined
from farhand.commands.completion import arm_names, experiment_names, motion_names, setting_words

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
    assert completed("remote", "--set", "robot.limits") == ["robot.limits_factor=", "robot.limits_factor=VALUE"]
    assert completed("local", "--config", "loc") == []


@pytest.mark.slow
@pytest.mark.parametrize(
    ("typed", "shown"),
    [
        ("remote --driver=kin", "remote --driver=kinematic END"),
        ("track --tracker=mar", "track --tracker=markers END"),
        ("remote --set=driver.name=kin", "remote --set=driver.name=kinematic END"),
        ("remote --set cell=a:b --set driver.name=kin", "--set driver.name=kinematic END"),
        ("local --set simulation.motion.name=rot", "--set simulation.motion.name=rotate_END"),
        ("remote --set robot.limits_f", "remote --set robot.limits_factor=END"),
    ],
)
def test_in_a_terminal_bash_completes_behind_an_equals_sign_and_puts_no_space_there(
    typed: str, shown: str, completed: Callable[..., list[str]], tmp_path: Path
) -> None:
    assert completed("--vers") == ["--version"]  # and the script is there
    terminal, end = pty.openpty()
    environment = os.environ | {"PATH": f"{tmp_path}:{os.environ['PATH']}", "PS1": "", "INPUTRC": os.devnull}
    with subprocess.Popen(
        ["bash", "--norc", "-i"], stdin=end, stdout=end, stderr=end, env=environment, start_new_session=True
    ) as shell:
        try:
            os.close(end)
            os.write(terminal, f"source '{tmp_path}/farhand.sh'; PS1=re''ady\n".encode())
            read_until(terminal, "ready")  # the prompt: from there on each key is bash's, not the terminal's
            os.write(terminal, f"farhand {typed}\tEND".encode())
            line = read_until(terminal, "END").replace("\a", "")
        finally:
            shell.kill()
            os.close(terminal)
    assert line.endswith(shown)


def read_until(terminal: int, mark: str) -> str:
    """What the terminal shows until this is read."""
    shown, patience_s = "", 60.0
    while mark not in shown:
        assert select.select([terminal], [], [], patience_s)[0], shown
        shown += os.read(terminal, 4096).decode()
    return shown


@pytest.mark.parametrize(
    ("parts", "words", "kept"),
    [
        (["remote", "--driver", "=", "kin"], ["remote", "--driver=kin"], "--driver="),
        (["remote", "--driver", "="], ["remote", "--driver="], "--driver="),
        (
            ["--set", "links.control", "=", "tcp/a", ":", "7"],
            ["--set", "links.control=tcp/a:7"],
            "links.control=tcp/a:",
        ),
        (["--set", "cell", "=", "a", ":"], ["--set", "cell=a:"], "cell=a:"),
        (["--set", "cell", "=", "a", "--set", "dr"], ["--set", "cell=a", "--set", "dr"], ""),
        (["--set", "cell", "=", ""], ["--set", "cell=", ""], ""),  # a space stands behind the sign
    ],
)
def test_words_that_bash_splits_are_put_together_again(parts: list[str], words: list[str], kept: str) -> None:
    assert joined(parts) == (words, kept)


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
        ("remote", "driver.name=k", {"driver.name=kinematic"}, {"driver.name=c500c"}),
        ("local", "tracking.method=m", {"tracking.method=markers", "tracking.method=monocular"}, set()),
        ("remote", "robot.model=", {"robot.model=a465", "robot.model=fr3", "robot.model=humanoid"}, set()),
        ("local", "simulation.motion.name=rotate_", {"simulation.motion.name=rotate_x"}, set()),
        ("remote", "driver.emulate=", {"driver.emulate=true", "driver.emulate=false"}, set()),
        ("remote", "engagement.mode=", {"engagement.mode=on_request", "engagement.mode=automatic"}, set()),
        ("local", "driver.name=", set(), {"driver.name=kinematic"}),
    ],
)
def test_a_command_completes_the_keys_of_the_sites_whose_settings_it_takes_and_the_values_that_are_known(
    words: str, incomplete: str, keys: set[str], others: set[str]
) -> None:
    context = typer.Context(typer.main.get_command(app), info_name=f"farhand {words}")
    found = set(setting_words(context, incomplete))
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
