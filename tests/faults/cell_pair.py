"""A pair of sites as real processes: a scripted operator, a recording driver, and everything that is heard of them."""

import shutil
import struct
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from contextlib import ExitStack
from datetime import UTC, datetime
from functools import partial
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from common.clock import NS_PER_S
from common.config import load_config
from common.geometry import Array, vector_from_rotation
from common.link.channels import ENGAGEMENT
from common.link.config import ON_THIS_HOST, LinkSecurity, TlsConfig
from common.link.endpoints import SECURED
from common.link.request_client import RequestClient
from common.link.transport import open_link
from common.messages.requests import EngagementAction, EngagementRequest, Reply
from common.messages.robot import RobotState, SessionState
from farhand.certificates.folder import CertificateOrder, create
from farhand.loopback.recorder import Recorder
from farhand.loopback.run import free_ports
from remote_site.config import RemoteConfig
from remote_site.kinematics.limits import JointLimits
from remote_site.kinematics.model import ArmModel
from remote_site.safety.config import FULL_SPEED_MS
from tests.faults.daemons import NOBODY, Daemon
from tests.faults.driver_log import DriverLog
from tests.faults.hand_path import HandPath
from tests.faults.namespaces import Network
from tests.faults.puppets import tell

A465 = "driver.name=c500c"
FARHAND = (sys.executable, "-m", "farhand")
CELL, OPERATOR = "faults", "anna"
TESTS = Path(__file__).parent
PATIENCE_S = 90.0
ENTRY_POINTS = "[farhand.drivers]\nrecording = recording_driver:RecordingDriver\n"
VIDEO = 'video.cameras=[{name="side",source="/dev/null-camera"}]'
MOVING_RAD_S = 0.15
CIRCLE_M, CIRCLE_HZ = (0.05, 0.04, 0.04), 0.5
NEAR = 0.02  # m and rad
SETTLES_S = 0.7  # of a glide, of what smooths it, and of the calm before a turned hand counts again
ATTEMPTS = 3
MEMORY = "/dev/shm"  # noqa: S108  # a robot's driver never waits for a disk


class CellPair:
    """The sites of one cell; through the link of `network` if there is one, else on one host.

    By QUIC they show certificates, as they have to there.
    """

    def __init__(self, network: Network | None, settings: tuple[str, ...] = (), protocol: str = "tcp") -> None:
        self.network, self._protocol = network, protocol
        self.stack = ExitStack()
        self.folder = Path(tempfile.mkdtemp(prefix="farhand-faults-", dir=MEMORY))
        self.stack.callback(shutil.rmtree, self.folder, ignore_errors=True)
        host = "localhost" if network else "127.0.0.1"
        control, video, listen = free_ports(3)
        self.control, self.video = f"{protocol}/{host}:{control}", f"tcp/{host}:{video}"
        if self._is_secured:
            create(self.folder, CertificateOrder(CELL, ("localhost",), 1), datetime.now(UTC))
        self.listen = f"tcp/127.0.0.1:{listen}"
        self.settings = (*self._own_settings(), *self._driver(settings))
        self.config = load_config(RemoteConfig, None, self.settings)
        robot = self.config.robot
        self.model = ArmModel.from_urdf(robot.urdf, robot.tool_frame, robot.tool_T_tcp)
        self.limits = JointLimits.from_model(self.model, robot)
        self._environment = self._plug_in()
        security = LinkSecurity(tls=self._tls("operator")) if self._is_secured else ON_THIS_HOST
        self.link = self.stack.enter_context(open_link(connect=(self.control,), security=security))
        self.states = Recorder(self.link, self.link, CELL, ()).record.states
        self.remote = self.local = NOBODY
        self.others: list[Daemon] = []
        self.path = HandPath.still()

    def start(self) -> None:
        """Start both sites, and the robot where it is a process of its own."""
        if A465 in self.settings:
            command = [sys.executable, str(TESTS / "emulated_robot.py"), str(self.folder)]
            self.others.append(Daemon("robot", command, self._environment))
            self.wait("the robot", (self.folder / "line").exists)
        self.start_remote()
        self.start_local()

    def start_remote(self) -> Daemon:
        """Start the remote site, and wait for its first state."""
        self.remote.end()
        before = len(self.states)
        self.remote = self._start("remote", [*FARHAND, "remote"], self.settings)
        self.wait("the remote site", lambda: len(self.states) > before)
        return self.remote

    def start_local(self) -> Daemon:
        """Start the local site, on the other host if there is one."""
        ear = self.folder / "hand"
        self.local.end()
        self.path = HandPath.still()
        command = [*self._beyond, sys.executable, str(TESTS / "scripted_local.py"), str(ear)]
        ear.unlink(missing_ok=True)
        links = f"links.remote={self.control}", f"links.listen={self.listen}", *self._certificate("operator")
        own = f"cell={CELL}", "tracking.method=markers", f"authority.operator={OPERATOR}"
        self.local = self._start("local", command, (*own, *links))
        self.wait("the scripted operator", ear.exists)
        return self.local

    def start_console(self) -> int:
        """Start the operator's console beside the local site; the port of its page."""
        (port,) = free_ports(1)
        links = f"links.control={self.control}", f"links.video={self.video}", f"links.local={self.listen}"
        settings = f"cell={CELL}", f"operator={OPERATOR}", f"serve.port={port}", *links
        self.others.append(self._start("console", [*self._beyond, *FARHAND, "console"], settings))
        return port

    def start_page(self, port: int) -> Daemon:
        """Open a page of the console; it listens to `page`."""
        ear = self.folder / "page"
        ear.unlink(missing_ok=True)
        command = [*self._beyond, sys.executable, str(TESTS / "page_client.py"), str(port), str(ear)]
        self.others.append(Daemon("page", command, self._environment))
        self.wait("the page", ear.exists)
        return self.others[-1]

    @property
    def _beyond(self) -> tuple[str, ...]:
        return self.network.beyond if self.network else ()

    @property
    def state(self) -> RobotState:
        """The newest state."""
        return self.states[-1]

    def is_in(self, state: SessionState) -> bool:
        """Whether the newest state is this one."""
        return self.state.state is state

    def wait(self, what: str, is_so: Callable[[], Any], seconds: float = PATIENCE_S) -> None:
        """Wait until something is so; AssertionError with the sites' last words otherwise."""
        deadline = time.monotonic() + seconds
        while not is_so():
            if time.monotonic() > deadline:
                words = [f"{p.name}: {(list(p.lines) or ['silent'])[-1]}" for p in (self.remote, self.local)]
                raise AssertionError(f"waited {seconds:g} s in vain for {what}: {words} {self.states[-1:]}")
            time.sleep(0.01)

    def ask(self, action: EngagementAction) -> Reply:
        """Ask the remote site in the operator's name."""
        make = partial(EngagementRequest, operator=OPERATOR, action=action)
        return RequestClient(self.link, CELL).ask(ENGAGEMENT, make)

    def engage(self) -> None:
        """Have the arm follow the hand, whatever had ended it, and lead it back to where it started."""
        for attempt in range(ATTEMPTS):
            place = self.take_up()
            way_s = 0.5 + 3.0 * float(np.abs(place).max())
            self.hand(to=(0,) * 6, seconds=way_s)
            try:
                self.wait("the arm to be back", lambda: np.abs(self.place_of_arm()).max() < NEAR, way_s + 3.0)
                return
            except AssertionError:  # a busy machine makes the arm hold, which shifts the hand against it
                if attempt == ATTEMPTS - 1:
                    raise

    def take_up(self) -> tuple[float, ...]:
        """Have the arm follow from where it stands, and say where the hand is then."""
        self.ask(EngagementAction.DISENGAGE)
        self.wait("rest", lambda: self.states[-1].q_commanded == self.states[-10].q_commanded, 5)
        place = self.place_of_arm()
        self.hand(lost=False, camera="", to=place, seconds=0.3)
        time.sleep(SETTLES_S)
        self.wait("the engagement", self._engages, 20)
        self.wait("the arm to follow", lambda: self.is_in(SessionState.ENGAGED), 10)
        return place

    def move(self) -> None:
        """Have the hand circle, as fast as the arm may go, and wait until it does."""
        pace = min(1.0, FULL_SPEED_MS / self.config.safety.t_soft_ms)
        self.hand(to=(0, 0.05, 0, 0, 0, 0), seconds=0.5 / pace, circle_m=CIRCLE_M, hz=CIRCLE_HZ * pace)
        time.sleep(0.6 / pace)
        self.wait(
            "the arm to move", lambda: self.log(time.monotonic_ns() - NS_PER_S).speed_at_end > MOVING_RAD_S * pace, 10
        )

    def _engages(self) -> bool:
        answer = self.ask(EngagementAction.ENGAGE)
        time.sleep(0.0 if answer.done else 0.2)
        return answer.done

    def place_of_arm(self) -> tuple[float, ...]:
        """Where the hand has to be engaged so that the arm is at its start when the hand is at home."""
        return self.place_of(np.array(self.state.q_commanded))

    def place_of(self, q: Array) -> tuple[float, ...]:
        """Where the hand has to be so that the tool is where it is in this posture."""
        start, now = (self.model.forward(posture) for posture in (self.config.robot.start, q))
        base_R_operator = np.array(self.config.mapping.base_R_operator)
        turn = vector_from_rotation(now[:3, :3] @ start[:3, :3].T)
        way = now[:3, 3] - start[:3, 3]
        return (*(way @ base_R_operator / self.config.mapping.scale).tolist(), *(turn @ base_R_operator).tolist())

    def hand(self, **words: Any) -> None:
        """Tell the scripted operator and his cameras."""
        if "to" in words:
            words["begun_ns"] = time.monotonic_ns()
            self.path = self.path.then(words)
        tell(self.folder / "hand", **words)

    def robot(self, **words: Any) -> None:
        """Tell the recording driver."""
        tell(self.folder / "robot", **words)

    def step_wall_clock(self, seconds: int) -> None:
        """Put the wall clock of all processes so far from the machine's, s."""
        with (self.folder / "wall_offset").open("r+b") as offset:
            offset.write(struct.pack("<q", seconds))

    def log(self, since_ns: int) -> DriverLog:
        """What the driver has recorded since a time."""
        return DriverLog.read(self.folder / "record", self.model, self.limits, since_ns)

    def close(self) -> None:
        """End everything."""
        for process in (*self.others, self.local, self.remote):
            process.end()
        self.stack.close()

    def _start(self, name: str, command: list[str], settings: tuple[str, ...]) -> Daemon:
        arguments = [part for setting in settings for part in ("--set", setting)]
        return Daemon(name, [*command, *arguments], self._environment)

    def _own_settings(self) -> tuple[str, ...]:
        return (
            f"cell={CELL}",
            f"links.control={self.control}",
            f"links.video={self.video}",
            "engagement.mode=on_request",
            VIDEO,
            *self._certificate("remote"),
        )

    @property
    def _is_secured(self) -> bool:
        return self._protocol in SECURED

    def _tls(self, who: str) -> TlsConfig:
        pair = self.folder / CELL / who
        return TlsConfig(ca=str(self.folder / "ca.pem"), certificate=f"{pair}.pem", key=f"{pair}.key")

    def _certificate(self, who: str) -> tuple[str, ...]:
        """The settings with which a site shows its certificate, where it has to."""
        shown = msgspec.structs.asdict(self._tls(who)) if self._is_secured else {}
        return tuple(f"links.tls.{key}={value}" for key, value in shown.items())

    def _driver(self, settings: tuple[str, ...]) -> tuple[str, ...]:
        """The recording driver, or the A465's at the line of an emulated controller of its own."""
        if A465 in settings:
            return *settings, f"driver.options.port={self.folder / 'line'}"
        paths = f"driver.options.record={self.folder / 'record'}", f"driver.options.orders={self.folder / 'robot'}"
        return "driver.name=recording", *paths, *settings

    def _plug_in(self) -> dict[str, str]:
        """The environment in which the recording driver is an installed one."""
        package = self.folder / "faults-1.dist-info"
        package.mkdir()
        (package / "METADATA").write_text("Metadata-Version: 2.1\nName: faults\nVersion: 1\n")
        (package / "entry_points.txt").write_text(ENTRY_POINTS)
        paths = [str(self.folder), str(TESTS), *sys.path]
        wall = self._wall_clock() if self.network is not None else {}
        return wall | {"PYTHONPATH": ":".join(filter(None, paths)), "STATE_DIRECTORY": str(self.folder)}

    def _wall_clock(self) -> dict[str, str]:
        """The environment in which the wall clock can be put to another time."""
        offset, library = self.folder / "wall_offset", self.folder / "wall_clock.so"
        offset.write_bytes(bytes(8))
        compiler = ["cc", "-O2", "-shared", "-fPIC", "-o", str(library), str(TESTS / "wall_clock.c"), "-ldl"]
        subprocess.run(compiler, check=True)
        return {"LD_PRELOAD": str(library), "FARHAND_WALL_OFFSET": str(offset)}
