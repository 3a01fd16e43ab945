"""An estimated palm commands the humanoid's through the whole chain: what was commanded, and what was reached."""

from collections import Counter
from dataclasses import dataclass

import numpy as np

from common.clock import NS_PER_MS
from common.geometry import Array
from lab.experiments.following import ToolPath, follow_estimates
from lab.experiments.report import CsvTable, Figures, rounded
from lab.experiments.robonaut.errors import MM, arm_figures, errors_mm, lengths, true_and_measured
from lab.experiments.robonaut.footage import Tracked, frame_ns
from local_site.samples.smoothing import SmoothingConfig, make_smoother
from local_site.tracking.tracker import ArmEstimate
from remote_site.config import RemoteConfig

LATENCY_MS = 10.0


@dataclass(frozen=True, slots=True)
class CommandedHumanoid:
    """The humanoid's palm in its base frame at every frame (N, 3), m, and its joints (N, n), rad.

    `commanded` follows from the frame's sample, NaN where there was none; `reached` is where the palm is when the next
    sample arrives; `true` is where the operator's true palm leads. `hindered` counts ticks by what kept the tool back.
    """

    commanded: Array
    reached: Array
    true: Array
    postures: Array
    hindered: Counter[str]


def command_humanoid(tracked: Tracked, still_frames: int, remote: RemoteConfig) -> CommandedHumanoid:
    """Smooth and send every estimate, and follow it; the results are of the frames after the still ones.

    The last frame is left out: it only ends the time in which the one before is pursued. ProcessError when the arm is
    never engaged.
    """
    sent = list(map(make_smoother(SmoothingConfig()).smooth, tracked.estimates))
    path = follow_estimates(sent, remote, LATENCY_MS)
    origin = next(k for k, estimate in enumerate(sent) if estimate.t_ns >= path.engaged_ns)
    true, _ = true_and_measured(tracked, "palm")
    frames = range(still_frames, len(sent) - 1)
    ticks = [_tick_before(path, frame_ns(k + 1) + round(LATENCY_MS * NS_PER_MS)) for k in frames]
    palms = np.array([_palm(estimate) for estimate in sent])
    at_origin = path.poses[0][:3, 3]
    shown = slice(frames.start, frames.stop)
    return CommandedHumanoid(
        commanded=at_origin + _in_base(palms - palms[origin], remote)[shown],
        reached=np.array([path.poses[tick][:3, 3] for tick in ticks]),
        true=at_origin + _in_base(true - true[origin], remote)[shown],
        postures=np.array([path.postures[tick] for tick in ticks]),
        hindered=path.hindered,
    )


def _tick_before(path: ToolPath, t_ns: int) -> int:
    """The number of the last tick before a time."""
    return max(int(np.searchsorted(path.times_ns, t_ns)) - 1, 0)


def _palm(estimate: ArmEstimate) -> Array:
    return np.full(3, np.nan) if estimate.palm is None else estimate.palm


def _in_base(moved: Array, remote: RemoteConfig) -> Array:
    """The operator's motion (N, 3) as the tool's, base frame, m."""
    base_R_operator = np.array(remote.mapping.base_R_operator)
    result: Array = remote.mapping.scale * moved @ base_R_operator.T
    return result


def commanded_figures(tracked: Tracked, commanded: CommandedHumanoid) -> Figures:
    """The tracker's errors, and how far palms are apart: estimated and true, commanded and reached, reached and true.

    `tracked` has the same frames.
    """
    return {
        **arm_figures(tracked),
        "palm_moved_mm": _spread(MM * (commanded.true - commanded.true[0])),
        "estimated_off_true_palm_mm": _spread(errors_mm(tracked, "palm")),
        "reached_off_commanded_palm_mm": _spread(MM * (commanded.reached - commanded.commanded)),
        "reached_off_true_palm_mm": _spread(MM * (commanded.reached - commanded.true)),
        "hindered_ticks": dict(commanded.hindered),
    }


def _spread(vectors_mm: Array) -> Figures:
    """Mean, 95th percentile and largest of the vectors' lengths, without NaN; empty where nothing is left."""
    distances = lengths(vectors_mm)
    known = distances[np.isfinite(distances)]
    if not len(known):
        return {}
    figures = {"mean": known.mean(), "p95": np.percentile(known, 95), "largest": known.max()}
    return {name: rounded(value) for name, value in figures.items()}


def commanded_table(tracked: Tracked, commanded: CommandedHumanoid) -> CsvTable:
    """A row for every frame: palms in the camera's frame and in the base's in mm, joints in degrees."""
    kinds = {
        **dict(zip(("true", "estimated"), true_and_measured(tracked, "palm"), strict=True)),
        "true_in_base": commanded.true,
        "commanded_in_base": commanded.commanded,
        "reached_in_base": commanded.reached,
    }
    joints = [f"joint_{k + 1}_deg" for k in range(commanded.postures.shape[1])]
    columns = ("frame", *(f"{kind}_{axis}_mm" for kind in kinds for axis in "xyz"), *joints)
    positions = [MM * rows for rows in kinds.values()]
    frames = np.arange(1, len(commanded.reached) + 1)
    return CsvTable(columns, np.column_stack([frames, *positions, np.degrees(commanded.postures)]))
