"""The robot and its gripper through pylibfranka, the maker's own client: the only importer of it.

Its calls wait and keep Python's lock meanwhile, a gripper's for a second: so nothing else may run in a process that
makes them.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

import numpy as np

from common.geometry import Array
from remote_site.drivers.franka.connecting import connection_error
from remote_site.drivers.franka.robot_errors import ERRORS
from remote_site.drivers.franka.robot_port import (
    ArmState,
    GripperWidth,
    LinkLostError,
    MotionAbortedError,
    RobotRefusedError,
)

if TYPE_CHECKING:
    from pylibfranka import ActiveControlBase, Errors, RobotState

MS_PER_S = 1000
NS_PER_MS = 1_000_000
ANY_WIDTH_M = 0.1  # of what is grasped: more than the gripper opens


class FrankaMotion:
    """A joint position motion under the robot's own joint impedance control."""

    def __init__(self, control: "ActiveControlBase") -> None:
        self._control = control

    def read(self) -> ArmState:
        """Wait for the next state."""
        with _named():
            return _arm_state(self._control.readOnce()[0])

    def write(self, q: Array, *, finished: bool) -> None:
        """Send the joints' next positions (7,) rad; the last ones end the motion."""
        import pylibfranka  # noqa: PLC0415  # an extra, and only this process needs it

        positions = pylibfranka.JointPositions(q.tolist())
        positions.motion_finished = finished
        with _named():
            self._control.writeOnce(positions)


class FrankaRobot:
    """A connection to the robot; UnreachableError when it cannot be made, DriverError where it never can."""

    def __init__(self, host: str, *, realtime: bool) -> None:
        import pylibfranka  # noqa: PLC0415  # an extra, and only this process needs it

        config = pylibfranka.RealtimeConfig
        self._mode = pylibfranka.ControllerMode.JointImpedance
        with _connecting(host):
            self._robot = pylibfranka.Robot(host, config.kEnforce if realtime else config.kIgnore)

    def read(self) -> ArmState:
        """Wait for the next state."""
        with _named():
            return _arm_state(self._robot.read_once())

    def start(self) -> FrankaMotion:
        """Begin a motion where the robot holds its joints."""
        with _named():
            return FrankaMotion(self._robot.start_joint_position_control(self._mode))

    def recover(self) -> None:
        """Acknowledge the robot's errors."""
        with _named():
            self._robot.automatic_error_recovery()


class FrankaGripper:
    """A connection to the gripper's server; UnreachableError when it cannot be made."""

    def __init__(self, host: str) -> None:
        import pylibfranka  # noqa: PLC0415  # an extra, and only this process needs it

        with _connecting(host):
            self._gripper = pylibfranka.Gripper(host)

    def read(self) -> GripperWidth:
        """Wait for the next state."""
        with _named():
            state = self._gripper.read_once()
        return GripperWidth(float(state.width), float(state.max_width))

    def open(self, width_m: float, speed_m_s: float) -> bool:
        """Open, and wait for it."""
        with _named():
            return bool(self._gripper.move(width_m, speed_m_s))

    def close(self, speed_m_s: float, force_n: float) -> bool:
        """Close on whatever is there, and wait for it; the force stays."""
        with _named():
            return bool(self._gripper.grasp(0.0, speed_m_s, force_n, ANY_WIDTH_M, ANY_WIDTH_M))


@contextmanager
def _connecting(host: str) -> Iterator[None]:
    """Say why there is no connection."""
    import pylibfranka  # noqa: PLC0415  # an extra, and only this process needs it

    try:
        yield
    except (pylibfranka.FrankaException, RuntimeError) as error:  # which all others are
        raise connection_error(host, str(error)) from error


@contextmanager
def _named() -> Iterator[None]:
    """Turn what pylibfranka raises into what the driver knows."""
    import pylibfranka  # noqa: PLC0415  # an extra, and only this process needs it

    try:
        yield
    except pylibfranka.NetworkException as error:
        raise LinkLostError(str(error)) from error
    except pylibfranka.ControlException as error:
        raise MotionAbortedError(str(error)) from error
    except (
        pylibfranka.CommandException,
        pylibfranka.InvalidOperationException,
        pylibfranka.FrankaException,
        RuntimeError,
    ) as error:
        raise RobotRefusedError(str(error)) from error


def _arm_state(state: "RobotState") -> ArmState:
    return ArmState(
        round(state.time.to_sec() * MS_PER_S) * NS_PER_MS,
        np.array(state.q),
        np.array(state.dq),
        np.array(state.q_d),
        state.robot_mode.name,
        _names(state.current_errors),
        _names(state.last_motion_errors),
    )


def _names(errors: "Errors") -> tuple[str, ...]:
    return tuple(name for name in ERRORS if getattr(errors, name)) if errors else ()
