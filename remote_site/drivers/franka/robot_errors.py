"""Every error of an FR3 by its name, as a fault with what it means and how it ends; pure."""

from collections.abc import Sequence

from common.text import cut
from remote_site.drivers.faults import MOST_NATIVE, FaultCode, RobotFault

RESET = "clear the arm's path, then reset"
TOO_HARD = "the commanded motion was broken off; reset, and lower robot.speed or robot.acceleration_rad_s2"
AT_LIMIT = "move the arm away from the limit by hand (in Desk's programming mode), then reset"
IN_DESK = "see the robot's page Desk, then reset"

# Names are libfranka's, in its order; what needs no other sentence is the robot's own affair.
ERRORS: dict[str, tuple[FaultCode, str]] = {
    "joint_position_limits_violation": (FaultCode.LIMITS, AT_LIMIT),
    "cartesian_position_limits_violation": (FaultCode.LIMITS, AT_LIMIT),
    "self_collision_avoidance_violation": (FaultCode.BLOCKED, AT_LIMIT),
    "joint_velocity_violation": (FaultCode.LIMITS, TOO_HARD),
    "cartesian_velocity_violation": (FaultCode.LIMITS, TOO_HARD),
    "force_control_safety_violation": (FaultCode.ROBOT, IN_DESK),
    "joint_reflex": (FaultCode.BLOCKED, f"a joint was pushed or has hit something; {RESET}"),
    "cartesian_reflex": (FaultCode.BLOCKED, f"the tool was pushed or has hit something; {RESET}"),
    "max_goal_pose_deviation_violation": (FaultCode.BLOCKED, RESET),
    "max_path_pose_deviation_violation": (FaultCode.BLOCKED, RESET),
    "cartesian_velocity_profile_safety_violation": (FaultCode.LIMITS, TOO_HARD),
    "joint_position_motion_generator_start_pose_invalid": (FaultCode.APART, "reset, where the arm stands"),
    "joint_motion_generator_position_limits_violation": (FaultCode.LIMITS, TOO_HARD),
    "joint_motion_generator_velocity_limits_violation": (FaultCode.LIMITS, TOO_HARD),
    "joint_motion_generator_velocity_discontinuity": (FaultCode.LIMITS, TOO_HARD),
    "joint_motion_generator_acceleration_discontinuity": (FaultCode.LIMITS, TOO_HARD),
    "cartesian_position_motion_generator_start_pose_invalid": (FaultCode.ROBOT, IN_DESK),
    "cartesian_motion_generator_elbow_limit_violation": (FaultCode.ROBOT, IN_DESK),
    "cartesian_motion_generator_velocity_limits_violation": (FaultCode.ROBOT, IN_DESK),
    "cartesian_motion_generator_velocity_discontinuity": (FaultCode.ROBOT, IN_DESK),
    "cartesian_motion_generator_acceleration_discontinuity": (FaultCode.ROBOT, IN_DESK),
    "cartesian_motion_generator_elbow_sign_inconsistent": (FaultCode.ROBOT, IN_DESK),
    "cartesian_motion_generator_start_elbow_invalid": (FaultCode.ROBOT, IN_DESK),
    "cartesian_motion_generator_joint_position_limits_violation": (FaultCode.ROBOT, IN_DESK),
    "cartesian_motion_generator_joint_velocity_limits_violation": (FaultCode.ROBOT, IN_DESK),
    "cartesian_motion_generator_joint_velocity_discontinuity": (FaultCode.ROBOT, IN_DESK),
    "cartesian_motion_generator_joint_acceleration_discontinuity": (FaultCode.ROBOT, IN_DESK),
    "cartesian_position_motion_generator_invalid_frame": (FaultCode.ROBOT, IN_DESK),
    "force_controller_desired_force_tolerance_violation": (FaultCode.ROBOT, IN_DESK),
    "controller_torque_discontinuity": (FaultCode.ROBOT, IN_DESK),
    "start_elbow_sign_inconsistent": (FaultCode.ROBOT, IN_DESK),
    "communication_constraints_violation": (
        FaultCode.LINK,
        "too many commands came late; check the cable to the robot and this machine's load, then reset",
    ),
    "power_limit_violation": (FaultCode.ROBOT, IN_DESK),
    "joint_p2p_insufficient_torque_for_planning": (FaultCode.ROBOT, IN_DESK),
    "tau_j_range_violation": (FaultCode.ROBOT, "a torque left its range; check the load that Desk knows, then reset"),
    "instability_detected": (FaultCode.ROBOT, IN_DESK),
    "joint_move_in_wrong_direction": (FaultCode.LIMITS, AT_LIMIT),
    "cartesian_spline_motion_generator_violation": (FaultCode.ROBOT, IN_DESK),
    "joint_via_motion_generator_planning_joint_limit_violation": (FaultCode.ROBOT, IN_DESK),
    "base_acceleration_initialization_timeout": (FaultCode.ROBOT, IN_DESK),
    "base_acceleration_invalid_reading": (FaultCode.ROBOT, IN_DESK),
}

# The modes in which an FR3 takes no motion, by libfranka's names, with what ends them.
MODES: dict[str, tuple[FaultCode, str]] = {
    "UserStopped": (FaultCode.EMERGENCY_STOP, "the robot's stop is pressed or its enabling device let go; release it"),
    "Guiding": (FaultCode.REFUSED, "the arm is guided by hand; let go of its buttons"),
    "AutomaticErrorRecovery": (FaultCode.REFUSED, "the robot recovers from an error; wait, then reset"),
    "Other": (FaultCode.ROBOT, "the robot takes no motion; unlock its brakes and activate FCI in Desk"),
    "Reflex": (FaultCode.ROBOT, f"a reflex has stopped the arm; {RESET}"),
}


def fault_of(names: Sequence[str], said: str = "") -> RobotFault | None:
    """The fault of the errors that a robot reports, by libfranka's names, None without one.

    The first that is more than the robot's own affair gives code and cure; all are named, and what libfranka `said`.
    """
    if not names:
        return None
    known = [(name, *ERRORS.get(name, (FaultCode.ROBOT, IN_DESK))) for name in names]
    name, code, cure = next((each for each in known if each[1] is not FaultCode.ROBOT), known[0])
    also = f" ({said})" if said else ""
    return RobotFault(code, f"{', '.join(names)}: {cure}{also}", cut(name, MOST_NATIVE))


def mode_fault(mode: str) -> RobotFault | None:
    """The fault of a mode in which the robot takes no motion, None of the others."""
    if mode not in MODES:
        return None
    code, sentence = MODES[mode]
    return RobotFault(code, sentence, mode)
