"""What bash completes after `farhand`, by the script that --install-completion writes."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

PROGRAM = "#!{python}\nimport sys\nsys.path[:0] = {path!r}\nfrom farhand.__main__ import main\nmain()\n"
COMPLETE = """
source "$1"; shift
COMP_WORDS=("$@") COMP_CWORD=$(($# - 1))
_farhand_completion farhand
printf '%s\\n' "${COMPREPLY[@]}"
"""


@pytest.fixture
def completed(tmp_path: Path):
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


def test_commands_options_and_choices_are_completed(completed) -> None:
    assert completed("sta") == ["status"]
    assert completed("maintenance", "") == ["stop", "reset"]
    assert {"--config", "--set", "--save-views"} <= set(completed("local", "--"))
    assert completed("track", "--tracker", "m") == ["markers", "monocular"]


def test_run_as_a_module_it_writes_the_same_script() -> None:
    # The shell is found among the parents, so bash has to stay: with one command alone it would become that.
    command = ["bash", "-c", f'"{sys.executable}" -m farhand --show-completion; exit $?']
    told = subprocess.run(command, capture_output=True, text=True, check=True)
    assert "_farhand_completion()" in told.stdout
