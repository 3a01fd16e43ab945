"""Chromium without a window, driven by its own protocol, for measurements.

Playwright has every message of a page's socket told to it, so that each picture would be sent twice, which takes as
much processor time as to paint it.
"""

import json
import re
import subprocess
import tempfile
import time
import urllib.request
from pathlib import Path
from typing import Any, Self

from websockets.sync.client import ClientConnection, connect

from common.errors import ProcessError
from lab.stage.processes import cpu_s, family

CHROMIUM = "/usr/bin/chromium"
QUIET = (
    "--no-sandbox",
    "--disable-gpu",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
)
SIZE = {"width": 1280, "height": 720}
BLANK = "about:blank"
END_S = 10.0
KEYS = {"Escape": "Escape", "r": "KeyR", "e": "KeyE"}


class Tab:
    """The one page of a browser."""

    def __init__(self, connection: ClientConnection) -> None:
        self._connection = connection
        self._asked = 0

    def evaluate(self, expression: str) -> Any:
        """The value of an expression of JavaScript; ProcessError with what the page says against it."""
        result = self.ask("Runtime.evaluate", expression=expression, returnByValue=True, awaitPromise=True)
        if "exceptionDetails" in result:
            raise ProcessError(f"the page cannot evaluate {expression[:80]}: {result['exceptionDetails']}")
        return result["result"].get("value")

    def press(self, key: str) -> None:
        """Press a key and release it."""
        for kind in ("keyDown", "keyUp"):
            self.ask("Input.dispatchKeyEvent", type=kind, key=key, code=KEYS[key])

    def close(self) -> None:
        """Leave the page, so that it takes no more pictures."""
        self.ask("Page.navigate", url=BLANK)
        self._connection.close()

    def ask(self, method: str, **params: Any) -> dict[str, Any]:
        """The result of a command of the browser's protocol; ProcessError where it is refused."""
        self._asked += 1
        self._connection.send(json.dumps({"id": self._asked, "method": method, "params": params}))
        while True:
            answer = json.loads(self._connection.recv())
            if answer.get("id") == self._asked:
                if "error" in answer:
                    raise ProcessError(f"{method}: {answer['error']['message']}")
                return dict(answer["result"])


class Chromium:
    """A browser of one page; ProcessError where Debian's chromium is missing."""

    def __init__(self) -> None:
        if not Path(CHROMIUM).exists():
            raise ProcessError("no chromium to open the page in; on Debian: apt-get install chromium")
        self._profile = tempfile.TemporaryDirectory(ignore_cleanup_errors=True)
        self._log = Path(self._profile.name) / "chromium.log"
        command = [
            CHROMIUM,
            "--headless",
            *QUIET,
            "--remote-debugging-port=0",
            f"--user-data-dir={self._profile.name}",
            BLANK,
        ]
        with self._log.open("wb") as log:
            self._process = subprocess.Popen(command, stdout=log, stderr=log)  # noqa: S603 - our own words
        self._host = self._debugging_host()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._process.terminate()
        self._process.wait(END_S)
        self._profile.cleanup()

    @property
    def pid(self) -> int:
        """Of the browser, whose children paint."""
        return self._process.pid

    @property
    def cpu_s(self) -> float:
        """The processor time that all its processes have used so far, s."""
        return sum(cpu_s(pid) for pid in family(self.pid))

    def open(self, address: str) -> Tab:
        """The page at this address."""
        with urllib.request.urlopen(f"http://{self._host}/json") as answer:
            page = next(target for target in json.load(answer) if target["type"] == "page")
        tab = Tab(connect(page["webSocketDebuggerUrl"], max_size=None))
        tab.ask("Emulation.setDeviceMetricsOverride", **SIZE, deviceScaleFactor=1, mobile=False)
        tab.ask("Page.navigate", url=address)
        while not tab.evaluate(f"location.href === {json.dumps(address)} && document.readyState === 'complete'"):
            time.sleep(0.05)
        return tab

    def _debugging_host(self) -> str:
        until = time.monotonic() + END_S
        while time.monotonic() < until:
            told = re.search(r"ws://([^/]+)/", self._log.read_text(encoding="utf-8", errors="replace"))
            if told:
                return told[1]
            time.sleep(0.05)
        self._process.kill()
        raise ProcessError(f"chromium has not started within {END_S:g} s")
