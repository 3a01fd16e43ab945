"""The processes of a pair of sites: their last log lines, and their children by name."""

import os
import subprocess
import threading
from collections import deque
from pathlib import Path

from common.process.children import die_with_parent

END_TIMEOUT_S = 6.0


class Daemon:
    """A process whose log lines are kept; it ends with this one."""

    def __init__(self, command: list[str], environment: dict[str, str]) -> None:
        self.lines: deque[str] = deque(maxlen=200)
        parent = os.getpid()
        self._process = subprocess.Popen(
            command,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            text=True,
            env=os.environ | environment,
            start_new_session=True,
            preexec_fn=lambda: die_with_parent(parent),  # noqa: PLW1509  # two system calls that take no lock
        )
        threading.Thread(target=self._listen, daemon=True).start()

    @property
    def pid(self) -> int:
        return self._process.pid

    @property
    def exit_code(self) -> int | None:
        return self._process.poll()

    def child(self, name: str) -> int:
        """The process id of a child by its name; ProcessLookupError without one."""
        for child in Path(f"/proc/{self.pid}/task/{self.pid}/children").read_text().split():
            if Path(f"/proc/{child}/comm").read_text().strip() == name:
                return int(child)
        raise ProcessLookupError(name)

    def end(self) -> None:
        """Ask it to end, kill it when it does not."""
        self._process.terminate()
        try:
            self._process.wait(END_TIMEOUT_S)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()

    def _listen(self) -> None:
        stream = self._process.stderr
        assert stream is not None
        with stream:
            for line in stream:
                self.lines.append(line.rstrip())
