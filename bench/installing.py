"""Installs other projects to compare with: each into a folder below build, not into this project's environment."""

import subprocess
from collections.abc import Mapping, Sequence

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
