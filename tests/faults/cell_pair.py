"""A pair of sites as real processes: a scripted operator, a recording driver, and a record of their states."""

import shutil
import struct
import tempfile
import time
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import numpy as np

from common.clock import NS_PER_S
from common.config.loading import load_config
from common.errors import ProcessError
from common.link.engagement_client import ask_engagement
from common.link.request_client import RequestClient
from common.link.transport import Link, open_link
from common.messages.requests import EngagementAction, Reply
from common.messages.robot import RobotState, SessionState
from farhand.loopback.recorder import Recorder
from farhand.loopback.site_process import SiteProcess, free_ports
from lab.stage.network.command_socket import send
from lab.stage.network.namespaces import LinkedHosts
from lab.stage.processes import module_command
from lab.stage.staged_sites import StagedSites
from lab.stage.stand_ins.commanded_hand import CommandedHand
from lab.stage.waiting import until
from remote_site.config import RemoteConfig
from remote_site.kinematics.limits import JointLimits
from tests.faults.driver_log import DriverLog
from tests.faults.pair_setup import A465, CELL, OPERATOR, PairSetup

PATIENCE_S = 90.0
MOVING_RAD_S = 0.15
CIRCLE_M, CIRCLE_HZ = (0.05, 0.04, 0.04), 0.5  # up to two thirds of what joint 3 can accelerate
CENTRE = (0.0, 0.05, -0.05, 0.0, 0.0, 0.0)  # from home, with the elbow well bent
NEAR = 0.02  # m and rad
SETTLES_S = 0.7  # of a glide, of what smooths it, and of the calm before a turned hand counts again
ATTEMPTS = 3
MEMORY = "/dev/shm"  # noqa: S108  # a robot's driver never waits for a disk


class CellPair:
    """The sites of one cell; through the link of `network` if there is one, else on one host.

    By QUIC they show certificates, as they have to there.
    """

    def __init__(self, network: LinkedHosts | None, settings: tuple[str, ...] = (), protocol: str = "tcp") -> None:
        self._network = network
        self.stack = ExitStack()
        folder = Path(tempfile.mkdtemp(prefix="farhand-faults-", dir=MEMORY))
        self.stack.callback(shutil.rmtree, folder, ignore_errors=True)
        self.setup = PairSetup.make(folder, settings, protocol, two_hosts=network is not None)
        self._sites = StagedSites(self.setup.environment())
        self.config = load_config(RemoteConfig, None, self.setup.remote)
        self.scripted = CommandedHand(folder / "hand", self.config)
        self.model = self.scripted.model
        self.limits = JointLimits.from_model(self.model, self.config.robot)
        self.link = self.link_of(OPERATOR)
        self.states = Recorder(self.link, self.link, CELL, (), OPERATOR).record.states

    def link_of(self, operator: str) -> Link:
        """A link of an operator to the remote site, with the certificate of that name where there are any."""
        link = open_link(connect=(self.setup.endpoints.control,), security=self.setup.security_of(operator))
        return self.stack.enter_context(link)

    def viewer(self) -> Link:
        """A link of a viewer, at the endpoint for viewers."""
        return open_link(connect=(self.setup.viewers,), security=self.setup.security_with("viewer"))

    def maintenance(self) -> Link:
        """A link of maintenance to the remote site."""
        return open_link(connect=(self.setup.endpoints.control,), security=self.setup.security_with("maintenance"))

    @property
    def folder(self) -> Path:
        """Where the pair's files and sockets are."""
        return self.setup.folder

    @property
    def remote(self) -> SiteProcess:
        """The remote site's process; KeyError before it has been started."""
        return self._sites.named("remote")

    @property
    def local(self) -> SiteProcess:
        """The local site's process; KeyError before it has been started."""
        return self._sites.named("local")

    def start(self) -> None:
        """Start both sites, and the robot where it is a process of its own."""
        if A465 in self.setup.driver_settings:
            self._start("robot", module_command("tests.faults.emulated_robot", self.folder))
            self.wait("the robot", (self.folder / "line").exists)
        self.start_remote()
        self.start_local()

    def start_remote(self, *settings: str) -> None:
        """Start the remote site, with other settings than the pair's perhaps, and wait for its first state."""
        self._sites.end_named("remote")
        before = len(self.states)
        self._start("remote", module_command("farhand", "remote"), (*self.setup.remote, *settings))
        self.wait("the remote site", lambda: len(self.states) > before)

    def start_local(self) -> None:
        """Start the local site, on the other host if there is one."""
        commands = module_command("lab.stage.stand_ins.scripted_local", self.folder / "hand")
        self._sites.end_named("local")
        self.scripted.forget()
        self._start("local", [*self._beyond, *commands], self.setup.local)
        self.wait("the scripted operator", (self.folder / "hand").exists)

    def start_path(self, task: str) -> None:
        """Have a taught task, as the text of its file, take the place of the local site."""
        self._sites.end_named("local")
        file = self.folder / "task.toml"
        file.write_text(task)
        self._start("local", [*self._beyond, *module_command("farhand", "teach", "run", file)], self.setup.local)

    @property
    def console(self) -> SiteProcess:
        """The console's process; KeyError before it has been started."""
        return self._sites.named("console")

    def start_console(self) -> int:
        """Start the operator's console beside the local site; the port of its page."""
        (port,) = free_ports(1)
        self._start("console", [*self._beyond, *module_command("farhand", "console")], self.setup.console(port))
        return port

    def end_console(self) -> None:
        """End the console and its page; the local site starts again, under a lease that knows no page."""
        for name in ("page", "console"):
            self._sites.end_named(name)
        self.start_local()

    def start_page(self, port: int, *, down: bool = False) -> SiteProcess:
        """Open a page of the console, perhaps with its key down already; it receives commands at `page`."""
        commands = self.folder / "page"
        commands.unlink(missing_ok=True)
        command = module_command("lab.stage.stand_ins.page_client", port, commands, *(["--down"] if down else []))
        page = self._start("page", [*self._beyond, *command])
        self.wait("the page", commands.exists)
        return page

    @property
    def _beyond(self) -> tuple[str, ...]:
        return self._network.beyond if self._network else ()

    @property
    def state(self) -> RobotState:
        """The newest state."""
        return self.states[-1]

    def is_in(self, state: SessionState) -> bool:
        """Whether the newest state is this one."""
        return self.state.state is state

    def wait(self, what: str, is_so: Callable[[], Any], seconds: float = PATIENCE_S) -> None:
        """Wait until something is so; ProcessError with the sites' last lines otherwise."""
        until(is_so, what, seconds, self._last_words)

    def _last_words(self) -> str:
        lines = [f"{p.name}: {(list(p.lines) or ['silent'])[-1]}" for p in self._sites.processes]
        return f"{lines} {self.states[-1:]}"

    def ask(self, action: EngagementAction, seen_ns: int | None = None) -> Reply:
        """Ask the remote site in the operator's name, who is shown what there is now, or was shown the halt given."""
        if action in (EngagementAction.ENGAGE, EngagementAction.RESET) and seen_ns is None:
            before = len(self.states)
            self.wait("the state as it is now", lambda: len(self.states) > before + 1, 5)
        client = RequestClient(self.link, CELL, operator=OPERATOR)
        return ask_engagement(client, action, self.state.halted_ns if seen_ns is None else seen_ns)

    def engage(self) -> None:
        """Have the arm follow the hand, whatever had ended it, and lead it back to where it started."""
        for attempt in range(ATTEMPTS):
            pose = self.follow_from_here()
            glide_s = 0.5 + 3.0 * float(np.abs(pose).max())
            self.hand(to=(0,) * 6, seconds=glide_s)
            try:
                self.wait("the arm to be back", lambda: np.abs(self.pose_of_arm()).max() < NEAR, glide_s + 3.0)
                return
            except ProcessError:  # a busy machine makes the arm hold, which shifts the hand against it
                if attempt == ATTEMPTS - 1:
                    raise

    def follow_from_here(self) -> tuple[float, ...]:
        """Have the arm follow from where it is; the hand's pose then."""
        self.ask(EngagementAction.RESET)
        self.wait("rest", lambda: self.states[-1].q_commanded == self.states[-10].q_commanded, 5)
        pose = self.pose_of_arm()
        self.hand(lost=False, camera="", to=pose, seconds=0.3)
        time.sleep(SETTLES_S)
        self.wait("the engagement", self._engages, 20)
        self.wait("the arm to follow", lambda: self.is_in(SessionState.ENGAGED), 10)
        return pose

    def move(self, share: float = 1.0) -> None:
        """Have the hand circle, at a share of how fast the arm may go, and wait until it does."""
        pace = share * self.state.speed_scale
        self.hand(to=CENTRE, seconds=0.5 / pace, circle_m=CIRCLE_M, hz=CIRCLE_HZ * pace)
        time.sleep(0.6 / pace)
        self.wait(
            "the arm to move", lambda: self.log(time.monotonic_ns() - NS_PER_S).speed_at_end > MOVING_RAD_S * pace, 10
        )

    def _engages(self) -> bool:
        answer = self.ask(EngagementAction.ENGAGE)
        time.sleep(0.0 if answer.done else 0.2)
        return answer.done

    def pose_of_arm(self) -> tuple[float, ...]:
        """The hand's pose at which to engage, so that the arm is at its start when the hand is at home."""
        return self.scripted.pose_of(np.array(self.state.q_commanded))

    def hand(self, **fields: Any) -> None:
        """Command the scripted operator and the cameras."""
        self.scripted.command(**fields)

    def robot(self, **fields: Any) -> None:
        """Command the recording driver."""
        send(self.folder / "robot", **fields)

    def impair(self, **fields: Any) -> None:
        """Impair the link between the two hosts; without fields it is a good one again."""
        assert self._network is not None, "only a pair on two hosts has a link to impair"
        self._network.impair(**fields)

    def step_wall_clock(self, seconds: int) -> None:
        """Put the wall clock of all processes this far from the machine's, s."""
        with (self.folder / "wall_offset").open("r+b") as offset:
            offset.write(struct.pack("<q", seconds))

    def log(self, since_ns: int) -> DriverLog:
        """What the driver has recorded since a time."""
        return DriverLog.read(self.folder / "record", self.model, self.limits, since_ns)

    def close(self) -> None:
        """End everything."""
        self._sites.end()
        self.stack.close()

    def _start(self, name: str, command: list[str], settings: tuple[str, ...] = ()) -> SiteProcess:
        self._sites.end_named(name)
        return self._sites.start(name, command, settings)
