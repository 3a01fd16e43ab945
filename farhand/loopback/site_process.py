"""A site as a process of its own under the loopback and the tests: started, listened to, ended, never left behind."""

import os
import socket
import subprocess
import sys
import threading
from collections import deque
from collections.abc import Iterable, Mapping, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import IO

from common.process.children import die_with_parent

LINES_KEPT = 200
END_TIMEOUT_S = 6.0
CONNECT_TIMEOUT_S = 0.05
ERROR_PREFIX = "farhand:"  # of the error with which a command ends


class SiteProcess:
    """A process whose log lines are kept, warnings and errors as events too; it ends with this one."""

    def __init__(self, name: str, command: Sequence[str], environment: Mapping[str, str]) -> None:
        self.name = name
        self.lines: deque[str] = deque(maxlen=LINES_KEPT)
        self.events: deque[str] = deque(maxlen=LINES_KEPT)
        parent = os.getpid()
        self._process = subprocess.Popen(  # noqa: S603  # our own program with our own arguments
            command,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            text=True,
            env=os.environ | environment,
            start_new_session=True,
            preexec_fn=lambda: die_with_parent(parent),  # noqa: PLW1509  # two system calls that take no lock
        )
        if self._process.stderr is not None:
            self._listener = threading.Thread(target=self._listen, args=(self._process.stderr,), daemon=True)
            self._listener.start()

    @property
    def pid(self) -> int:
        return self._process.pid

    @property
    def exit_code(self) -> int | None:
        """None while it runs."""
        return self._process.poll()

    def end(self) -> None:
        """Ask it to end, and kill it when it does not."""
        if self._process.poll() is None:
            self._process.terminate()
        try:
            self._process.wait(END_TIMEOUT_S)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
            self.events.append(f"{self.name} had to be killed")
        self._listener.join(END_TIMEOUT_S)

    def last_error(self) -> str:
        """Why it ended: the error that it printed last; else its last logged error, else its last line."""
        if self.exit_code is not None:
            self._listener.join(END_TIMEOUT_S)
        lines = list(self.lines)
        ends = [k for k, line in enumerate(lines) if line.startswith(ERROR_PREFIX)]
        if ends:
            return "\n".join(lines[ends[-1] :]).removeprefix(ERROR_PREFIX).strip()
        errors = [line for line in lines if line.startswith("level=error")]
        return (errors or lines or ["it printed nothing"])[-1]

    def _listen(self, stream: IO[str]) -> None:
        with stream:
            for line in stream:
                self.lines.append(line.rstrip())
                if not line.startswith("level=info"):
                    self.events.append(f"{self.name}: {line.rstrip()}")


def start_site(name: str, arguments: Sequence[str], runtime: Path) -> SiteProcess:
    """Start a command of this installation; `runtime` is the folder of its state, to end with whoever starts it."""
    return SiteProcess(name, module_command("farhand", name, *arguments), {"STATE_DIRECTORY": str(runtime)})


def module_command(module: str, *arguments: str) -> list[str]:
    """The command that runs a module of this installation, whatever the working folder holds."""
    return [sys.executable, "-P", "-m", module, *arguments]


def options_of(settings: Iterable[str]) -> list[str]:
    """The words of a command line that give these settings, each as table.key=value."""
    return [part for setting in settings for part in ("--set", setting)]


def free_ports(count: int) -> list[int]:
    """Free ports of the loopback interface."""
    with ExitStack() as stack:
        probes = [stack.enter_context(socket.socket()) for _ in range(count)]
        for probe in probes:
            probe.bind(("127.0.0.1", 0))
        return [int(probe.getsockname()[1]) for probe in probes]


def listens(port: int) -> bool:
    """Return whether a process listens on a port of the loopback interface."""
    with socket.socket() as probe:
        probe.settimeout(CONNECT_TIMEOUT_S)
        return probe.connect_ex(("127.0.0.1", port)) == 0
