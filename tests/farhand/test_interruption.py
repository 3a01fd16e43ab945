"""Ctrl-C and SIGTERM end every command with 130 and a word, whatever it does at that moment."""

import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from common.link.config import ON_THIS_HOST
from common.link.pubsub import Latest
from farhand.doctor.link.probing import LinkProber, measure_link

STOP_SIGNALS = [signal.SIGINT, signal.SIGTERM]
SILENT = "tcp/127.0.0.1:9"
NOT = "STOP NOT ACKNOWLEDGED: the arm may still move, use the emergency stop. interrupted before an answer came"
SEND = "import os, signal; os.kill(os.getpid(), {number})"


def farhand(program: str, *arguments: str) -> subprocess.CompletedProcess[str]:
    """Run the command line after a program that prepares the process."""
    start = f"{program}\nimport sys; sys.argv[0] = 'farhand'\nfrom farhand.__main__ import main; main()"
    command = [sys.executable, "-c", start, *arguments]
    return subprocess.run(command, check=False, capture_output=True, text=True, timeout=60)


def sent_within(number: int, target: str, *, swallowed: bool = False) -> str:
    """A program in which the signal comes to `farhand` in the import of a module, at worst where Python ignores it."""
    send = SEND.format(number=number)
    if swallowed:
        send = f"""
import weakref
class Lock: pass
lock = Lock()
import importlib._bootstrap as bootstrap
code = compile("def forgotten(_): import os; os.kill(os.getpid(), {number})", "<frozen importlib._bootstrap>", "exec")
space = {{}}
exec(code, space)
watch = weakref.ref(lock, space["forgotten"])
del lock
"""
    return f"""
import sys
from importlib.abc import MetaPathFinder
class Sender(MetaPathFinder):
    def find_spec(self, name, path, target=None):
        if name == {target!r}:
            exec({send!r}, {{}})
sys.meta_path.insert(0, Sender())
"""


@pytest.mark.parametrize("number", STOP_SIGNALS)
@pytest.mark.parametrize("swallowed", [False, True])
@pytest.mark.parametrize("module", ["farhand.cli", "farhand.deployment.checking", "numpy"])
def test_a_signal_within_an_import_ends_the_command(
    number: int, module: str, tmp_path: Path, *, swallowed: bool
) -> None:
    (tmp_path / "remote.toml").write_text('[robot]\nmodel = "a465"\n')
    program = sent_within(number, module, swallowed=swallowed)
    done = farhand(program, "config", "check", str(tmp_path / "remote.toml"))
    assert (done.returncode, done.stdout, done.stderr) == (130, "", "farhand: interrupted\n")


@pytest.mark.parametrize("words", [["stop"], ["maintenance", "stop"]])
def test_a_stop_that_is_interrupted_before_it_is_asked_is_not_acknowledged(words: list[str]) -> None:
    done = farhand(sent_within(signal.SIGINT, "farhand.authority"), *words)
    assert (done.returncode, done.stderr) == (130, f"farhand: {NOT}\n")


def sent_while(waiting: str, number: int) -> str:
    """A program in which the signal comes when a function is called that a command waits in."""
    module, _, name = waiting.rpartition(".")
    return f"""
import importlib, os
def waiting(*_, **__): os.kill(os.getpid(), {number})
module, _, owner = {module!r}.partition(":")
found = importlib.import_module(module)
setattr(getattr(found, owner) if owner else found, {name!r}, waiting)
"""


@pytest.mark.parametrize("number", STOP_SIGNALS)
@pytest.mark.parametrize(
    ("waiting", "words", "said"),
    [
        ("farhand.authority.asking._first_up", ["stop", "--remote", SILENT], NOT),
        ("farhand.authority.asking._first_up", ["maintenance", "stop", "--remote", SILENT], NOT),
        ("farhand.authority.asking._first_up", ["engage", "--remote", SILENT], "interrupted"),
        ("farhand.arm_import.import_arm.read_urdf", ["arm", "import", "arm.urdf"], "interrupted"),
        ("farhand.doctor.machine.probe_python", ["doctor"], "interrupted"),
        ("farhand.doctor.link.probing:LinkProber.measure", ["doctor", "--link"], "interrupted"),
    ],
)
def test_a_command_that_is_interrupted_says_so(number: int, waiting: str, words: list[str], said: str) -> None:
    done = farhand(sent_while(waiting, number), *words)
    assert (done.returncode, done.stdout, done.stderr) == (130, "", f"farhand: {said}\n")


def test_a_probe_that_is_interrupted_waits_for_what_listens(monkeypatch: pytest.MonkeyPatch) -> None:
    """A thread that comes back from Zenoh while Python ends would abort the process."""
    ended, feed = [], Latest.feed

    def slow(latest: Latest[Any], take: Callable[[Any, int], None]) -> None:
        feed(latest, take)
        time.sleep(0.1)
        ended.append(latest)

    def interrupted(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(Latest, "feed", slow)
    monkeypatch.setattr(LinkProber, "measure", interrupted)
    with pytest.raises(KeyboardInterrupt):
        measure_link(SILENT, ON_THIS_HOST, "cell", "anna")
    assert len(ended) == 3
