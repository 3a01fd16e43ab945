"""The tool's path of a recorded episode, as the hand led it: to be run on a robot again."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import islice
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from common.clock import NS_PER_S
from common.errors import RecordingError, RefusedError
from common.geometry import Array
from common.link.channels import STATE
from common.messages.codec import decode
from common.messages.recording import EpisodeOutcome
from common.messages.requests import Description
from common.messages.robot import GripperCommand, RobotState, SessionState
from common.recording.folder import parts_from
from common.recording.reader import RecordingReader, as_recorded
from common.recording.recorded_episodes import RecordedEpisode, read_episodes
from local_site.programmed.approach import approach, why_too_far
from local_site.programmed.tool_trajectory import GripperAction, ToolTrajectory
from remote_site.teleop.gripper_toggles import OPPOSITE

STEP_S = 0.02
MOST_POSES = 500_000  # more than an hour of states at 100 Hz


@dataclass(frozen=True)
class RecordedPath:
    """The path, its number of episode, and how the gripper was before it (None: there was none that is measured)."""

    episode: int
    path: ToolTrajectory
    gripper_at_start: GripperCommand | None


def recorded_path(file: Path, cell: str, episode: int | None) -> RecordedPath:
    """The tool's target of all states of an episode in which the arm followed; of the only one where none is given.

    Where it did not follow, the time is cut out; an episode without an end lasts to that of the recording.
    RecordingError where there is no such episode, or it has no motion.
    """
    chosen = _chosen(file, read_episodes(parts_from(file)), episode)
    if chosen.begin_ns is None:
        raise RecordingError(f"episode {chosen.number} begins in a file before {file}: give the one where it begins")
    wanted = file, STATE.key_for(cell), chosen.begin_ns, chosen.end_ns
    followed = list(islice(filter(_follows, _states(*wanted)), 2))
    if len(followed) < 2:
        raise RecordingError(f"in episode {chosen.number} of {file} the arm never followed the hand: choose another")
    start = followed[0]
    gripper = OPPOSITE[start.gripper_next] if start.gripper else None
    return RecordedPath(chosen.number, path_of(_states(*wanted)), gripper)


def check_cell(recorded: Description, cell: Description) -> None:
    """RefusedError where the recorded arm is not this cell's."""
    if recorded.robot != cell.robot or [j.name for j in recorded.joints] != [j.name for j in cell.joints]:
        raise RefusedError(f"the recording is of {recorded.robot}, this cell has {cell.robot}: use such an arm")


def _chosen(file: Path, episodes: Sequence[RecordedEpisode], number: int | None) -> RecordedEpisode:
    if not episodes:
        raise RecordingError(f"{file} has no episode: the arm was not engaged while it was recorded")
    found = [episode for episode in episodes if number in (None, episode.number)]
    if len(found) == 1:
        return found[0]
    wrong = f"{file} has no episode {number}" if number is not None else f"{file} has {len(episodes)} episodes"
    raise RecordingError("\n".join([f"{wrong}: choose one by --episode", *map(_in_words, episodes)]))


def _in_words(episode: RecordedEpisode) -> str:
    number, begin_ns, end_ns, task, outcome, note = episode
    lasts = f"{(end_ns - begin_ns) / NS_PER_S:.1f} s" if begin_ns is not None and end_ns is not None else "not ended"
    said = outcome.value if outcome is not EpisodeOutcome.UNKNOWN else ""
    return f"  {number}: " + ", ".join(filter(None, [lasts, said, task, note]))


def _states(file: Path, topic: str, begin_ns: int, end_ns: int | None) -> Iterator[RobotState]:
    for part in parts_from(file):
        with RecordingReader(part) as recording, as_recorded(part):
            for message in recording.messages([topic], begin_ns, end_ns):
                yield decode(message.data, RobotState, STATE.max_bytes)


def path_of(states: Iterable[RobotState]) -> ToolTrajectory:
    """The targets one after the other; from one engagement, or hold, to the next by a slow approach.

    States have the time of the robot's reading. Several of one reading are one place of the path, but each toggle of
    the gripper counts, also where the arm does not follow. RecordingError for a path that is too long to be kept.
    """
    path = _PathUnderWay()
    for state in states:
        if _follows(state):
            path.add(state)
        path.note_gripper(state)
        if max(len(path.poses), len(path.actions)) > MOST_POSES:
            raise RecordingError(f"the path has more than {MOST_POSES} places: choose a shorter episode")
    poses = np.array(path.poses)
    orientations = Rotation.from_matrix(poses[:, :3, :3]).as_quat()
    return ToolTrajectory(np.array(path.t_s), poses[:, :3, 3], orientations, actions=tuple(path.actions))


class _PathUnderWay:
    """The path as far as it is known: poses (4 x 4) at the times `t_s`, and what the gripper did until then."""

    def __init__(self) -> None:
        self.t_s, self.poses, self.actions = list[float](), list[Array](), list[GripperAction]()
        self._origin: tuple[int, int] | None = None
        self._begin_s, self._begin_ns = 0.0, 0
        self._before: RobotState | None = None

    def add(self, state: RobotState) -> None:
        """Go on to the target of a state in which the arm follows, unless it is no later than the last."""
        if _origin(state) != self._origin:
            self._begin(state)
        at_s = self._begin_s + (state.t_ns - self._begin_ns) / NS_PER_S
        if not self.t_s or at_s > self.t_s[-1]:
            self.t_s.append(at_s)
            self.poses.append(_target(state))

    def note_gripper(self, state: RobotState) -> None:
        """Have the gripper do what toggles since the state before have commanded."""
        before, restarts = self._before, self._before is not None and self._before.session != state.session
        toggles = 0 if before is None or restarts else state.gripper_toggles_applied - before.gripper_toggles_applied
        if toggles < 0:
            return  # it comes late
        if before is not None and toggles and self.t_s:
            command = before.gripper_next if toggles % 2 else OPPOSITE[before.gripper_next]
            self.actions.append(GripperAction(self.t_s[-1], command))
        self._before = state

    def _begin(self, state: RobotState) -> None:
        """Cross to where the arm follows from now on."""
        if self.poses:
            if too_far := why_too_far(self.poses[-1], _target(state)):
                raise RecordingError(f"the recorded path cannot be run: {too_far}")
            crossing = approach(self.poses[-1], _target(state))
            self.poses += [crossing.base_T_tool(at_s) for at_s in crossing.t_s[1:-1]]
            self.t_s += [self.t_s[-1] + at_s for at_s in crossing.t_s[1:-1].tolist()]
        self._begin_s = self.t_s[-1] + STEP_S if self.t_s else 0.0
        self._origin, self._begin_ns = _origin(state), state.t_ns


def _follows(state: RobotState) -> bool:
    return state.state is SessionState.ENGAGED and state.target is not None


def _origin(state: RobotState) -> tuple[int, int]:
    engagement = state.engagement
    return (engagement.number, engagement.hand_capture_ns) if engagement is not None else (0, 0)


def _target(state: RobotState) -> Array:
    if state.target is None:
        raise RecordingError("a state without target is none in which the arm followed")
    return state.target.transform()
