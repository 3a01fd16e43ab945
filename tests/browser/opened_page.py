"""A page opened in the browser, and what a person would see of it."""

import time
from collections.abc import Callable, Iterator
from itertools import count
from typing import Any

PATIENCE_S = 30.0
READING_MS = 600  # longer than the page takes for what nobody can have read
FOLLOWING = ("engaged", "limited", "behind", "led")
STAMPS = """() => [...document.querySelectorAll('#cameras .picture')].map((picture) => {
  const { width, height } = picture.getBoundingClientRect();
  const canvas = Object.assign(document.createElement("canvas"), { width, height });
  canvas.getContext("2d").drawImage(picture, 0, 0, width, height);
  return canvas.toDataURL();
})"""

LAID_OUT = """async ([width, height]) => {
  const frame = () => new Promise(requestAnimationFrame);
  const boxes = () =>
    JSON.stringify([...document.querySelectorAll(".view, #step")].map((e) => e.getBoundingClientRect()));
  for (let tries = 0, before = ""; tries < 100; tries++) {
    await frame();
    await frame();
    const now = boxes();
    if (now === before && innerWidth === width && innerHeight === height) return true;
    before = now;
  }
  return false;
}"""


class OpenedPage:
    """One tab of its own; `words`, `wait_for` and `hold` are what tests need most."""

    def __init__(self, browser: Any, address: str, script: str = "") -> None:
        """`script` is run before those of the page."""
        self.context = browser.new_context(viewport={"width": 1280, "height": 720}, has_touch=True)
        self.context.add_init_script(script)
        self.page = self.context.new_page()
        self.errors: list[str] = []
        self.page.on("pageerror", lambda error: self.errors.append(str(error)))
        self.page.on("console", lambda said: self.errors.append(said.text) if said.type == "error" else None)
        self._open(address)

    def _open(self, address: str) -> None:
        deadline = time.monotonic() + PATIENCE_S
        while True:  # the console may still be starting
            try:
                self.page.goto(address)
                return
            except Exception:
                if time.monotonic() > deadline:
                    raise
                time.sleep(0.2)

    def close(self) -> None:
        self.context.close()

    def resize(self, width: int, height: int) -> None:
        """Give the page another size, and wait until it is laid out: the page arranges its views a frame later."""
        self.page.set_viewport_size({"width": width, "height": height})
        assert self.page.evaluate(LAID_OUT, [width, height]), "the page does not come to rest at its new size"

    def wear(self, theme: str) -> None:
        """Switch to the dark or the light page."""
        if self.page.get_attribute("html", "data-theme") != theme:
            self.page.click("#theme")

    def words(self, selector: str) -> str:
        """The text of an element."""
        return str(self.page.text_content(selector) or "")

    def state(self) -> str:
        """The state's word, in small letters."""
        return self.words("#state-word").lower()

    @property
    def follows(self) -> bool:
        """Whether the arm follows, at a limit or behind the hand too."""
        return self.page.get_attribute("#state", "data-state") in FOLLOWING

    def marks(self) -> list[str]:
        """What the views of the cell are marked as."""
        return list(self.page.eval_on_selector_all("#cameras .view", "(views) => views.map((v) => v.dataset.mark)"))

    def wait_for_live_views(self) -> None:
        """Wait until each of the four views has been live, on a busy machine not all at the same instant."""
        seen: set[int] = set()

        def all_seen() -> bool:
            seen.update(k for k, mark in enumerate(self.marks()) if mark == "live")
            return seen == {0, 1, 2, 3}

        self.wait_for("four live views", all_seen)

    def pictures(self) -> list[str]:
        """The painted pictures of the cell."""
        return list(self.page.evaluate(STAMPS))

    def wait_for(self, what: str, is_so: Callable[[], bool], seconds: float = PATIENCE_S) -> float:
        """Wait until something is so; how long it took, s."""
        began = time.monotonic()
        while not is_so():
            told = f"{self.state()}: {self.words('#reason')}; {self.words('#alert')}; {self.errors}"
            assert time.monotonic() - began < seconds, f"waited in vain for {what}: {told}"
            self.page.wait_for_timeout(20)
        return time.monotonic() - began

    def settle(self) -> None:
        """Release the key, and reset a stop."""
        self.page.keyboard.up("Space")
        self.wait_for("a state", lambda: self.state() in ("disengaged", "stopped", "silent"))
        if self.state() == "stopped":
            self.page.wait_for_timeout(READING_MS)
            self.page.keyboard.press("r")
            self.wait_for("the reset", lambda: self.state() == "disengaged")

    def wait_until_ready(self) -> None:
        """Wait until only the key is missing."""
        operating = "you operate"
        self.wait_for("the controls", lambda: operating in self.words("#seat"))
        self.wait_for("readiness", lambda: self.follows or "waiting to be engaged" in self.words("#reason"))

    def hold(self, until: Callable[[], bool] | None = None) -> None:
        """Hold the space bar until the arm follows, or longer.

        On a machine so busy that the page itself missed a heartbeat, which rightly stops the arm, press it again.
        """
        self.wait_until_ready()
        tries = count()
        self.wait_for(
            "the arm to follow", lambda: self._pressed_anew(tries) and (until is None or until()), 2 * PATIENCE_S
        )

    def _pressed_anew(self, tries: Iterator[int]) -> bool:
        """Whether the arm follows; if not, press the key again, and give it longer each time."""
        if self.follows or self.state() == "holding":
            return self.follows
        self.page.keyboard.up("Space")
        self.page.wait_for_timeout(150)
        self.page.keyboard.down("Space")
        for _ in range(40 * (1 + next(tries))):
            if self.follows:
                break
            self.page.wait_for_timeout(25)
        return False
