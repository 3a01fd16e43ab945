"""The sites on two hosts, a scripted operator, a page; what they do is recorded."""

import shutil
import tempfile
import time
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path
from typing import Self

import numpy as np

from common.config.loading import load_config
from common.errors import TransportError
from common.link.engagement_client import ask_engagement
from common.link.request_client import RequestClient
from common.link.transport import open_link
from common.messages.requests import EngagementAction, Reply
from common.messages.robot import RobotState, SessionState
from farhand.loopback.recorder import Recorder
from lab.measure.wan.setup import CELL, OPERATOR, WanSetup
from lab.stage.network.command_socket import send
from lab.stage.network.namespaces import LinkedHosts
from lab.stage.processes import ROOT, module_command
from lab.stage.staged_sites import StagedSites
from lab.stage.stand_ins.commanded_hand import CommandedHand
from remote_site.config import RemoteConfig

MEMORY = "/dev/shm"  # noqa: S108  # nothing on the way of a picture waits for a disk
START_S = 60.0
AGAIN_S = 0.2
CALM_S = 0.7  # until what smooths the hand has come to rest too
FIGURE_M, FIGURE_HZ = (0.05, 0.04, 0.0), 0.2  # a figure of eight at up to 0.07 m/s, which the arm can follow at 400 ms
GLIDE_S = 2.0


class WanStage:
    """Everything is up while the block lasts; `states` are those of the remote site since the start.

    They are taken on its own host, so that the link's trouble does not touch them. All processes share one clock.
    """

    def __init__(self, source: Path, *, watched: bool = False) -> None:
        """`source` is the folder of the pictures that the cameras play; viewers are let in where it is `watched`."""
        self._source, self._stack = source, ExitStack()
        self.folder = Path(tempfile.mkdtemp(prefix="farhand-wan-", dir=MEMORY))
        self._stack.callback(shutil.rmtree, self.folder, ignore_errors=True)
        self.setup = WanSetup.make(self.folder)
        self._remote = self.setup.remote + (self.setup.watched if watched else ())
        self.network = LinkedHosts()
        self.sites = StagedSites({"PYTHONPATH": str(ROOT), "STATE_DIRECTORY": str(self.folder)})
        self.config = load_config(RemoteConfig, None, self.setup.remote)
        self.hand = CommandedHand(self._socket("hand"), self.config)

    def __enter__(self) -> Self:
        with self._stack as stack:
            self._start_all()
            self._stack = stack.pop_all()
        return self

    def __exit__(self, *_: object) -> None:
        self._stack.close()

    def _start_all(self) -> None:
        self._stack.callback(self.network.close)
        self.network.enter()
        self._stack.callback(self.sites.end)
        stand_in, beyond = "lab.stage.stand_ins.", self.network.beyond
        self.sites.start("remote", module_command(stand_in + "played_remote", self._source), self._remote)
        control, security = self.setup.endpoints.control, self.setup.security
        link = self._stack.enter_context(open_link(connect=(control,), security=security))
        self._client = RequestClient(link, CELL, operator=OPERATOR)
        self.sites.listen(Recorder(link, link, CELL, (), OPERATOR))
        self._wait("the remote site", lambda: self.states)
        local = module_command(stand_in + "scripted_local", self._socket("hand"))
        self.sites.start("local", [*beyond, *local], self.setup.local)
        console = module_command(stand_in + "recorded_console", self._socket("console"))
        self.sites.start("console", [*beyond, *console], self.setup.console)
        for name in ("hand", "console"):
            self._wait(name, self._socket(name).exists)

    @property
    def states(self) -> list[RobotState]:
        """All states that have come, in order."""
        return self.sites.record.states

    @property
    def state(self) -> RobotState:
        """The newest state."""
        return self.states[-1]

    def since(self, t_ns: int) -> list[RobotState]:
        """The states since a time."""
        return [state for state in self.states if state.t_ns > t_ns]

    def open_page(self, name: str) -> tuple[Path, Path]:
        """Open a page; the files in which its pictures are kept, and what it has seen."""
        pictures, seen = self.folder / f"{name}.pictures", self.folder / f"{name}.seen"
        for path in (pictures, seen):
            path.touch()
        send(self._socket("console"), file=str(pictures))
        words = module_command(
            "lab.stage.stand_ins.page_client", self.setup.page_port, self._socket("page"), "--sight", seen
        )
        self.sites.start("page", [*self.network.beyond, *words])
        return pictures, seen

    def record(self, folder: Path) -> None:
        """Have the remote site's recorder keep all that it does in a folder."""
        self.sites.start("record", module_command("farhand", "record", "--out", folder), self._remote)

    def close_page(self) -> None:
        """Close it."""
        self.sites.end_named("page")
        send(self._socket("console"), file="")

    def engage(self, within_s: float) -> bool:
        """Have the arm follow a figure of eight; False when it does not engage in this time."""
        if self.state.state is SessionState.FAULT:
            self._ask(EngagementAction.RESET)
        self.disengage()
        time.sleep(AGAIN_S)
        self.hand.command(to=self.hand.pose_of(np.array(self.state.q_commanded)), seconds=AGAIN_S)
        time.sleep(CALM_S)
        deadline = time.monotonic() + within_s
        while (answer := self._ask(EngagementAction.ENGAGE)) is None or not answer.done:
            if time.monotonic() > deadline:
                return False
            time.sleep(AGAIN_S)
        self.hand.command(to=(0.0,) * 6, seconds=GLIDE_S, circle_m=FIGURE_M, hz=FIGURE_HZ)
        return True

    def disengage(self) -> None:
        """Have the arm rest."""
        self._wait("an answer", lambda: self._ask(EngagementAction.DISENGAGE) is not None)

    def _ask(self, action: EngagementAction) -> Reply | None:
        """The answer; None where a busy site gives none."""
        try:
            return ask_engagement(self._client, action, self.state.halted_ns)
        except TransportError:
            return None

    def _socket(self, name: str) -> Path:
        return self.folder / f"{name}.socket"

    def _wait(self, what: str, is_so: Callable[[], object]) -> None:
        self.sites.wait(what, is_so, START_S)
