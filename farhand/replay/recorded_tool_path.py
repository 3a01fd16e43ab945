"""The tool's path of a recorded episode, as the hand led it: to be run on a robot again."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import groupby
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
from local_site.programmed.approach import approach
from local_site.programmed.tool_trajectory import GripperAction, ToolTrajectory
from remote_site.teleop.gripper_toggles import OPPOSITE

STEP_S = 0.02


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
    found = _states(file, STATE.key_for(cell), chosen.begin_ns, chosen.end_ns)
    states = [state for state in found if state.target is not None]
    if len(states) < 2:
        raise RecordingError(f"in episode {chosen.number} of {file} the arm never followed the hand: choose another")
    return RecordedPath(chosen.number, path_of(states), OPPOSITE[states[0].gripper_next] if states[0].gripper else None)


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
                state = decode(message.data, RobotState, STATE.max_bytes)
                if state.state is SessionState.ENGAGED:
                    yield state


def path_of(states: Sequence[RobotState]) -> ToolTrajectory:
    """The targets one after the other; from one engagement, or hold, to the next by a slow approach."""
    times, poses, actions = list[float](), list[Array](), list[GripperAction]()
    for _, stretch in groupby(states, key=_origin):
        kept = list(stretch)
        begin_s = 0.0
        if poses:
            crossing = approach(poses[-1], _target(kept[0]))
            poses += [crossing.base_T_tool(at_s) for at_s in crossing.t_s[1:-1]]
            times += [times[-1] + at_s for at_s in crossing.t_s[1:-1].tolist()]
            begin_s = times[-1] + STEP_S
        for before, state in zip([kept[0], *kept], kept, strict=False):
            at_s = begin_s + (state.t_ns - kept[0].t_ns) / NS_PER_S
            if times and at_s <= times[-1]:
                continue
            times.append(at_s)
            poses.append(_target(state))
            if (state.gripper_toggles_applied - before.gripper_toggles_applied) % 2:
                actions.append(GripperAction(at_s, before.gripper_next))
    orientations = Rotation.from_matrix(np.array(poses)[:, :3, :3]).as_quat()
    return ToolTrajectory(np.array(times), np.array(poses)[:, :3, 3], orientations, actions=tuple(actions))


def _origin(state: RobotState) -> tuple[int, int]:
    engagement = state.engagement
    return (engagement.number, engagement.hand_capture_ns) if engagement is not None else (0, 0)


def _target(state: RobotState) -> Array:
    if state.target is None:
        raise RecordingError("a state without target is none in which the arm followed")
    return state.target.transform()
