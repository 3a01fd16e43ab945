"""A site as a process of its own under the loopback: started, listened to, ended, never left behind."""

import os
import subprocess
import sys
import threading
from collections import deque
from pathlib import Path
from typing import IO

from common.process.children import die_with_parent

LINES_KEPT = 200
END_TIMEOUT_S = 4.0


class SiteProcess:
    """One daemon of this installation; its log lines are kept, warnings and errors are handed on.

    `runtime` is the folder of its run-time files, so that they end with whoever starts the sites.
    """

    def __init__(self, name: str, arguments: list[str], runtime: Path) -> None:
        self.name = name
        self.lines: deque[str] = deque(maxlen=LINES_KEPT)
        self.events: deque[str] = deque(maxlen=LINES_KEPT)
        parent = os.getpid()
        self._process = subprocess.Popen(  # noqa: S603  # our own program with our own arguments
            [sys.executable, "-m", "farhand", name, *arguments],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            text=True,
            env=os.environ | {"STATE_DIRECTORY": str(runtime)},
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
        """The last line that says why it ended."""
        errors = [line for line in self.lines if line.startswith(("level=error", "farhand:"))]
        return (errors or list(self.lines) or ["it said nothing"])[-1]

    def _listen(self, stream: IO[str]) -> None:
        with stream:
            for line in stream:
                self.lines.append(line.rstrip())
                if not line.startswith("level=info"):
                    self.events.append(f"{self.name}: {line.rstrip()}")
