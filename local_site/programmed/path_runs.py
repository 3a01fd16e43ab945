"""A program on a cell: what it needs, asked in each session of the remote site, and its runs, announced; pure."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np

from common.clock import NS_PER_S
from common.errors import RefusedError
from common.messages.hand import TrackingStatus
from common.messages.requests import Description
from common.messages.robot import GripperCommand, RobotState
from local_site.programmed.led_hand import shown_hand
from local_site.programmed.path_progress import PathProgress, RunOrder
from local_site.programmed.path_run import PathRun
from local_site.tracking.tracker import ArmEstimate

UNKNOWN = "the remote site has to say what its cell is: wait, or start it"
APART_NS = NS_PER_S // 2  # of announcements


@dataclass(frozen=True)
class PathProgram:
    """A program to run: its progress on the path, how the gripper has to be before, and whether a hold may end in it.

    `kind` is what the path is, in a word: recorded, or taught. `check` raises where it is not for this cell; `orders`
    are the operator's since it was called last.
    """

    kind: str
    name: str
    progress: PathProgress
    gripper_at_start: GripperCommand | None
    goes_on: bool
    check: Callable[[Description], None]
    orders: Callable[[], Iterable[RunOrder]]

    def check_cell(self, cell: Description) -> None:
        """RefusedError for a cell that the path is not for, or whose arm would follow it while nobody holds a key."""
        if not cell.held:
            raise RefusedError(
                f'the arm of {cell.cell} would move without a person at the key: set engagement.mode = "hold_to_run" '
                '(or "pedal") at the remote site, and start it again'
            )
        self.check(cell)


class PathRuns:
    """The hand of a program's runs; `session` is this local site's.

    `describe` asks the remote site what the cell is, None while it does not answer. It is asked again whenever the
    state's session is another: a site that has started again may have another mode, mapping or arm.
    """

    def __init__(self, program: PathProgram, session: int, describe: Callable[[], Description | None]) -> None:
        self._program, self._session, self._describe = program, session, describe
        self._run: PathRun | None = None
        self._remote: int | None = None
        self._toggled = 0

    @property
    def toggles(self) -> int:
        """The gripper's toggles of all runs so far."""
        return self._toggled + (self._run.toggles if self._run is not None else 0)

    def hand(self, now_ns: int, state: RobotState | None) -> ArmEstimate:
        """The hand of this instant; `state` is the remote site's newest, None while it is silent.

        RefusedError where the remote site's present session has a cell that the program is not for.
        """
        if state is not None and state.session != self._remote:
            self._ask(state.session)
        if self._run is None:
            return shown_hand(np.eye(4), now_ns, TrackingStatus.INITIALISING, UNKNOWN)
        return self._run.hand(now_ns, state)

    def _ask(self, remote: int) -> None:
        """Begin again for this session of the remote site, once it has said what the cell is."""
        self._toggled, self._run, self._remote = self.toggles, None, None
        cell = self._describe()
        if cell is None:
            return
        program = self._program
        program.check_cell(cell)
        self._remote = remote
        self._run = PathRun(
            program.progress, cell.mapping, self._session, program.gripper_at_start, goes_on=program.goes_on
        )


class Announcements:
    """Passes words of a run on to `tell` when they change, at most twice a second; the last always come in the end."""

    def __init__(self, tell: Callable[[str], object]) -> None:
        self._tell = tell
        self._told, self._told_ns = "", -APART_NS

    def offer(self, words: str, now_ns: int) -> None:
        """Announce what holds now if it has changed, but not too often; to be called again and again."""
        if words != self._told and now_ns - self._told_ns >= APART_NS:
            self._told, self._told_ns = words, now_ns
            self._tell(words)
