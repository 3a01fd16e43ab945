"""Hand against tool, per frame, as in the thesis's figures 6.15 and 6.16: the curves, the lag, the residual; pure."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from common.clock import NS_PER_MS
from common.geometry import Array
from lab.experiments.report import Figures, rounded
from remote_site.teleop.mapping import thesis_angles

COLUMNS = ("x_mm", "y_mm", "z_mm", "xy_deg", "xz_deg")
POSITION, ANGLES = slice(0, 3), slice(3, 5)
LAGS_MS = np.arange(0.0, 2001.0, 2.0)
GRID_NS = 10 * NS_PER_MS
Times = NDArray[np.integer | np.floating]  # whole ns, and those less a lag


@dataclass(frozen=True, slots=True)
class Curves:
    """Motion since the origin, operator frame: positions in mm, directions in the XY and XZ plane in degrees.

    One row of COLUMNS for each of `frames_ns`: the hand as it truly was, as it was measured (NaN where it was not), and
    the tool. `truth` (M, 5) are the true rows at `truth_ns`, close enough together to be interpolated. `gripper_mm` are
    the gripper's openings at `frames_ns`, NaN without a gripper, and `hand_open` is whether the hand was seen open.
    """

    frames_ns: Times
    hand_true: Array
    hand_measured: Array
    tool: Array
    truth_ns: Times
    truth: Array
    gripper_mm: Array
    hand_open: Array


def pointing(wrist: Array, index: Array, thumb: Array) -> Array:
    """Compute where the hand points (3,): from the wrist to the middle between the tips (thesis section 4.2)."""
    return 0.5 * (index + thumb) - wrist


def hand_rows(wrists: Array, directions: Array, origin: Array, ahead: Array) -> Array:
    """Rows of COLUMNS from wrists (N, 3) in m and directions (N, 3), since an origin and the direction there."""
    return np.column_stack([1e3 * (wrists - origin), _angles(directions) - _angles(ahead[None])])


def tool_rows(poses: Array, base_R_operator: Array, scale: float, ahead: Array) -> Array:
    """Rows of COLUMNS from poses (N, 4, 4), turned into the operator's axes.

    The tool's rotation since the first pose is given as a direction: `ahead`, turned by the same rotation.
    """
    moved = (poses[:, :3, 3] - poses[0, :3, 3]) @ base_R_operator / scale
    turned = poses[:, :3, :3] @ poses[0, :3, :3].T
    directions = base_R_operator.T @ (turned @ (base_R_operator @ ahead))[..., None]
    return hand_rows(moved, directions[..., 0], np.zeros(3), ahead)


def with_closed_hand(rows: Array, is_closed: Array) -> Array:
    """Rows (N, 5) whose angles are interpolated where the hand is not closed (N,): its tips give no direction then."""
    times = np.arange(len(rows))
    bridged = [np.interp(times, times[is_closed], rows[is_closed, k]) for k in range(*ANGLES.indices(rows.shape[1]))]
    return np.column_stack([rows[:, POSITION], *bridged])


def gripper_figures(openings_mm: Array) -> Figures:
    """The gripper's opening (N,): at first, the least, and in the end; nothing where none is measured."""
    if np.isnan(openings_mm).any():
        return {}
    first, least, last = openings_mm[0], openings_mm.min(), openings_mm[-1]
    return {"gripper_mm": {"at_first": rounded(first), "least": rounded(least), "in_the_end": rounded(last)}}


def rows_at(times_ns: Times, known_ns: Times, rows: Array) -> Array:
    """Rows (N, 5) at other times, interpolated; rows with NaN are left out."""
    known = np.isfinite(rows).all(axis=1)
    return np.column_stack([np.interp(times_ns, known_ns[known], rows[known, k]) for k in range(rows.shape[1])])


def follow_figures(curves: Curves, from_ns: int) -> Figures:
    """Lag and residual of the tool behind the true and behind the measured hand, over the frames since `from_ns`."""
    true = curves.truth_ns, curves.truth
    measured = curves.frames_ns.astype(float), curves.hand_measured
    moving = curves.frames_ns >= from_ns
    frames_ns, tool = curves.frames_ns[moving], curves.tool[moving]
    seen = np.isfinite(curves.hand_measured).all(axis=1) & moving
    tracked = curves.hand_measured[seen] - curves.hand_true[seen]
    return {
        "frames": int(moving.sum()),
        "frames_without_hand": int(moving.sum() - seen.sum()),
        "tool_behind_true_hand": _behind(frames_ns, tool, *true),
        "tool_behind_measured_hand": _behind(frames_ns, tool, *measured),
        "measured_against_true_hand": {"mm": _spread(_distance(tracked)), **_by_angle(tracked)},
    }


def _behind(frames_ns: Times, tool: Array, hand_ns: Times, hand: Array) -> Figures:
    """The lags at which the curves fit best, for position and angles; the residual there, and without any lag.

    A constant offset, as of the tracker, makes no lag: the search removes it, the residual keeps it.
    """

    def off(lag_ms: float) -> Array:
        difference: Array = tool - rows_at(frames_ns - lag_ms * NS_PER_MS, hand_ns, hand)
        return difference

    every = [off(float(lag)) for lag in LAGS_MS]
    shapes = [rows - rows.mean(axis=0) for rows in every]
    position = int(np.argmin([_distance(rows).mean() for rows in shapes]))
    turn = int(np.argmin([np.hypot(*rows[:, ANGLES].T).mean() for rows in shapes]))
    return {
        "lag_ms": float(LAGS_MS[position]),
        "residual_mm": _spread(_distance(every[position])),
        "residual_by_axis_mm": {axis: rounded(np.abs(every[position][:, k]).mean()) for k, axis in enumerate("xyz")},
        "angle_lag_ms": float(LAGS_MS[turn]),
        "residual_deg": _by_angle(every[turn]),
        "apart_at_the_same_instant": {"mm": _spread(_distance(every[0])), **_by_angle(every[0])},
    }


def _angles(directions: Array) -> Array:
    """Directions (N, 3) as angles (N, 2) in degrees in the XY and the XZ plane, without jumps at half a turn."""
    origin = np.zeros(3)
    angles = np.array([thesis_angles(origin, ahead, ahead)[:2] for ahead in directions])
    # The simulated hand points along -x, where the angles have their seam: there they are counted from -x.
    from_seam: Array = np.degrees(np.mod(angles, 2.0 * np.pi))
    return from_seam


def _distance(rows: Array) -> Array:
    distance: Array = np.linalg.norm(rows[:, POSITION], axis=1)
    return distance


def _by_angle(rows: Array) -> Figures:
    return {name: _spread(np.abs(rows[:, k])) for k, name in ((3, "xy_deg"), (4, "xz_deg"))}


def _spread(values: Array) -> Figures:
    figures = {"mean": values.mean(), "p95": np.percentile(values, 95), "max": values.max()}
    return {name: rounded(value) for name, value in figures.items()}
