"""Features of a frame of the dataset: its columns, by LeRobot's names, and their description; pure."""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from common.clock import NS_PER_S
from common.geometry import Array
from farhand.export.resampling import SessionRows, ViewsAt
from farhand.export.session import SessionFacts, Times

STATE, ACTION, TOOL = "observation.state", "action", "tool.pose"
IMAGES = "observation.images."
TIME = "time."
UNKNOWN_S = -1.0
KNOWN_TIMES = "frame", "state", "action", "hand", "hand_operator"
TOOL_NAMES = ("x", "y", "z", "qx", "qy", "qz", "qw")
COUNTED = ("timestamp", "frame_index", "episode_index", "index", "task_index")
Column = NDArray[Any]


class DatasetShape(NamedTuple):
    """The properties that all episodes of a dataset have in common."""

    robot: str
    joint_names: tuple[str, ...]
    has_gripper: bool
    views: Mapping[str, tuple[int, int]]
    fps: int

    @property
    def axes(self) -> list[str]:
        """The names of state and action."""
        return [f"{name}.pos" for name in self.joint_names] + ["gripper.pos"] * self.has_gripper


def shape_of(facts: SessionFacts, views: Sequence[str], fps: int) -> DatasetShape:
    """The shape that a session gives a dataset of these views."""
    sizes = {view: facts.views[view] for view in views}
    return DatasetShape(facts.robot, facts.joint_names, facts.has_gripper, sizes, fps)


def features(shape: DatasetShape) -> dict[str, dict[str, Any]]:
    """Every column and video by name, as info.json describes it."""
    axes, views = shape.axes, shape.views
    described: dict[str, dict[str, Any]] = {
        STATE: _feature("float32", [len(axes)], axes),
        ACTION: _feature("float32", [len(axes)], axes),
        TOOL: _feature("float32", [len(TOOL_NAMES)], list(TOOL_NAMES)),
    }
    described |= {IMAGES + view: _video(size, shape.fps) for view, size in views.items()}
    described |= {name: _feature("float64", [1], None) for name in time_columns(tuple(views))}
    described["timestamp"] = _feature("float32", [1], None)
    described |= {name: _feature("int64", [1], None) for name in COUNTED[1:]}
    return described


def time_columns(views: Sequence[str]) -> list[str]:
    """The names of the columns with true times."""
    return [TIME + name for name in (*KNOWN_TIMES, *(f"images.{view}" for view in views))]


def columns(shape: DatasetShape, rows: SessionRows, shown: Sequence[ViewsAt], begin_ns: int) -> dict[str, Column]:
    """The columns of an episode, by name: state, action, tool, and the true times in s since the episode's beginning.

    `time.hand_operator` alone is by the clock of the operator's host, since `operator_clock_at` the beginning. Where no
    sample was followed, both times of the hand are -1.
    """
    state, action = rows.q, rows.sent_q
    if shape.has_gripper and rows.opening is not None:
        state = np.column_stack((state, rows.opening))
        action = np.column_stack((action, rows.sent_opening))
    exposures = {
        f"images.{view}": np.array([at.pictures[view].capture_ns for at in shown], np.int64) for view in shape.views
    }
    by_host = {"frame": rows.instants, "state": rows.q_ns, "action": rows.sent_ns, "hand": rows.hand_ns, **exposures}
    times = {TIME + name: _seconds(t_ns, begin_ns) for name, t_ns in by_host.items()}
    times[TIME + "hand_operator"] = _seconds(rows.hand_operator_ns, operator_clock_at(begin_ns, rows))
    frame = np.arange(len(rows.instants), dtype=np.int64)
    return {
        STATE: state.astype(np.float32),
        ACTION: action.astype(np.float32),
        TOOL: rows.tool.astype(np.float32),
        **{name: times[name] for name in time_columns(tuple(shape.views))},
        "timestamp": (frame / shape.fps).astype(np.float32),
        "frame_index": frame,
    }


def operator_clock_at(begin_ns: int, rows: SessionRows) -> int:
    """The operator's clock at the episode's beginning, by its first sample that was followed; 0 without one, ns."""
    followed = np.flatnonzero(rows.hand_ns)
    if not len(followed):
        return 0
    first = followed[0]
    return int(rows.hand_operator_ns[first] - rows.hand_ns[first]) + begin_ns


def _seconds(t_ns: Times, begin_ns: int) -> Array:
    """Exact to the nanosecond, and readable by viewers that take no integers."""
    return np.where(t_ns == 0, UNKNOWN_S, (t_ns - begin_ns) / NS_PER_S)


def _feature(dtype: str, shape: list[int], names: list[str] | None) -> dict[str, Any]:
    return {"dtype": dtype, "shape": shape, "names": names}


def _video(size: tuple[int, int], fps: int) -> dict[str, Any]:
    width, height = size
    info = {
        "video.height": height,
        "video.width": width,
        "video.codec": "h264",
        "video.pix_fmt": "yuv420p",
        "video.is_depth_map": False,
        "video.fps": fps,
        "video.channels": 3,
        "has_audio": False,
    }
    return _feature("video", [height, width, 3], ["height", "width", "channels"]) | {"info": info}
