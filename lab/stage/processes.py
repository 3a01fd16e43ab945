"""Other processes: what they cost, from /proc; and commands that install projects to compare with, below build."""

import os
import subprocess
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path

from common.errors import ProcessError

ROOT = Path(__file__).parents[2]
KB_PER_MB = 1024
PIP = ("-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--no-input", "--only-binary", ":all:")


class UnavailableError(Exception):
    """Something cannot be measured here; the message states why."""


def run_quietly(command: Sequence[str], timeout_s: float, env: Mapping[str, str] | None = None) -> None:
    """Run a command to its end; UnavailableError with its own reason when it fails."""
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=timeout_s, check=False, env=env)  # noqa: S603 - our own words
    except (OSError, subprocess.TimeoutExpired) as error:
        raise UnavailableError(str(error)) from error
    if done.returncode:
        raise UnavailableError(reason(done.stderr) or f"{command[0]} ended with {done.returncode}")


def reason(text: str) -> str:
    """The line that states the error: the last one that names one, else the last."""
    lines = [line.strip() for line in text.splitlines() if line.strip()]
    errors = [line for line in lines if "error" in line.lower()]
    return (errors or lines or [""])[-1]


def module_command(name: str, *arguments: object) -> list[str]:
    """The command that runs a module of this repository; it needs ROOT as its folder or on its path."""
    return [sys.executable, "-m", name, *map(str, arguments)]


def cpu_s(pid: int) -> float:
    """The processor time that a process has used so far, without its children, s."""
    fields = Path(f"/proc/{pid}/stat").read_text(encoding="utf-8").rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def memory_mb(pid: int) -> float:
    """The resident memory of a process, MB."""
    lines = Path(f"/proc/{pid}/status").read_text(encoding="utf-8").splitlines()
    return next(float(line.split()[1]) for line in lines if line.startswith("VmRSS")) / KB_PER_MB


def child_of(pid: int, name: str) -> int:
    """The child process of this name; ProcessError without one."""
    for child in children(pid):
        if name_of(child) == name:
            return child
    raise ProcessError(f"process {pid} has no child {name}")


def name_of(pid: int) -> str:
    """The name that a process goes by."""
    return Path(f"/proc/{pid}/comm").read_text(encoding="utf-8").strip()


def children(pid: int) -> list[int]:
    """The processes that a process has started and that run."""
    return [int(entry.name) for entry in Path("/proc").iterdir() if entry.name.isdecimal() and _parent(entry) == pid]


def family(pid: int) -> list[int]:
    """A process, its children, and theirs."""
    return [pid, *(each for child in children(pid) for each in family(child))]


def keep_on_core(pid: int, core: int) -> None:
    """Let all threads of a process and of its children run on one processor core alone."""
    for each in family(pid):
        for thread in Path(f"/proc/{each}/task").iterdir():
            os.sched_setaffinity(int(thread.name), {core})


def _parent(entry: Path) -> int | None:
    """The process that has started this one; None where it has just ended."""
    try:
        return int((entry / "stat").read_text(encoding="utf-8").rpartition(")")[2].split()[1])
    except OSError:
        return None
