"""Why something was refused or stopped: every code with its sentence, in one table."""

from dataclasses import dataclass
from enum import StrEnum


class Code(StrEnum):
    """The short word of a refusal or of a state's reason; counted, sent in `RobotState`, stable over releases."""

    OK = "ok"
    # the hand sample
    DUPLICATE = "duplicate"
    OLD = "old"
    STALE = "stale"
    FUTURE = "future"
    NOT_FINITE = "not_finite"
    LOST = "lost"
    INITIALISING = "initialising"
    NO_WRIST = "no_wrist"
    UNCERTAIN = "uncertain"
    JUMP = "jump"
    JUMPS = "jumps"
    NO_OFFSET = "no_offset"
    OLD_OFFSET = "old_offset"
    # the lease
    NO_LEASE = "no_lease"
    NOT_HOLDER = "not_holder"
    OLD_LEASE = "old_lease"
    LEASE_LOST = "lease_lost"
    LEASE_HELD = "lease_held"
    LEASE_RELEASED = "lease_released"
    NOBODY_ASKS = "nobody_asks"
    HANDED_OVER = "handed_over"
    OPERATORS_ONLY = "operators_only"
    # the session
    NOT_ENGAGED = "not_engaged"
    NO_HAND = "no_hand"
    COLLECTING = "collecting"
    READY = "ready"
    LATCHED = "latched"
    NEW_SESSION = "new_session"
    RELEASED = "released"
    STOPPED = "stopped"
    RESET = "reset"
    ACTIVATED = "activated"
    NOT_HELD = "not_held"
    LET_GO_FIRST = "let_go_first"
    LET_GO = "let_go"
    ROBOT_NOT_READY = "robot_not_ready"
    MOVING = "moving"
    PAUSED = "paused"
    FAULT = "fault"
    # the target
    OUT_OF_REACH = "out_of_reach"
    IK_LIMIT = "ik_limit"
    STANCE = "stance"
    SATURATED = "saturated"
    NOT_A_POSE = "not_a_pose"
    UNREACHED = "unreached"
    SINGULAR = "singular"
    OBSTACLE = "obstacle"
    # the command
    POSITION = "position"
    VELOCITY = "velocity"
    ACCELERATION = "acceleration"
    JERK = "jerk"
    INCONSISTENT = "inconsistent"
    WORKSPACE = "workspace"
    COLLISION = "collision"
    NO_TRAJECTORY = "no_trajectory"
    COMMAND_TIMEOUT = "command_timeout"


SENTENCES: dict[Code, str] = {
    Code.OK: "the arm follows the hand",
    Code.DUPLICATE: "sample {seq} came twice",
    Code.OLD: "sample {seq} is older than the newest, {newest}",
    Code.STALE: "newest hand sample is {age_ms:.0f} ms old (limit {limit_ms:.0f} ms)",
    Code.FUTURE: "the sample was captured {ahead_ms:.0f} ms in the future: the clocks disagree",
    Code.NOT_FINITE: "the {what} is not finite",
    Code.LOST: "the hand is lost: {reason}",
    Code.INITIALISING: "tracking is initialising: {reason}",
    Code.NO_WRIST: "the sample lacks the point of the hand that the tool copies: {reason}",
    Code.UNCERTAIN: "the wrist is known to {sigma_mm:.0f} mm only (limit {limit_mm:.0f} mm)",
    Code.JUMP: "the wrist jumped {distance_mm:.0f} mm in {interval_ms:.0f} ms",
    Code.JUMPS: "the wrist jumped in {count} samples in a row",
    Code.NO_OFFSET: "the clock offset of the local site is not known yet",
    Code.OLD_OFFSET: "the clock offset of the local site was measured {age_ms:.0f} ms ago (limit {limit_ms:.0f} ms)",
    Code.NO_LEASE: "nobody holds the lease of this cell: start a local site, which asks for it, "
    "or if one runs: farhand lease take",
    Code.NOT_HOLDER: "{holder} holds the lease of this cell, and has to give or release it, or to let it expire",
    Code.OLD_LEASE: "lease {number} is not in force any more",
    Code.LEASE_LOST: "the lease of {holder} has ended",
    Code.LEASE_HELD: "the lease of this cell is yours",
    Code.LEASE_RELEASED: "the lease is given back",
    Code.NOBODY_ASKS: "nobody asks for the lease, so it cannot be handed over",
    Code.HANDED_OVER: "the lease went to {holder}",
    Code.OPERATORS_ONLY: "maintenance may stop and reset the arm; the rest is the operator's",
    Code.NOT_ENGAGED: "not engaged yet",
    Code.NO_HAND: "no hand sample has come yet",
    Code.COLLECTING: "{count} of {needed} good hand samples in a row",
    Code.READY: "ready: waiting to be engaged",
    Code.LATCHED: "disengaged, {cause}; engage again to go on",
    Code.NEW_SESSION: "the local site started anew; engage to go on",
    Code.RELEASED: "disengaged on request",
    Code.STOPPED: "stopped by {operator}; reset it, then engage",
    Code.RESET: "reset; engage to go on",
    Code.ACTIVATED: "the robot is awake again; engage once more",
    Code.NOT_HELD: "the {input} is not held down",
    Code.LET_GO_FIRST: "let go of the {input} first, then press it: what has ended does not start again by itself",
    Code.LET_GO: "disengaged: the {input} was let go",
    Code.ROBOT_NOT_READY: "the robot is not ready: {reason}",
    Code.MOVING: "the arm is still coming to rest",
    Code.PAUSED: "control stood still for {paused_ms:.0f} ms (limit {limit_ms:.0f} ms)",
    Code.FAULT: "{cause}; reset it, then engage",
    Code.OUT_OF_REACH: "the target is out of reach: its wrist is {distance_mm:.0f} mm from the shoulder, "
    "where {least_mm:.0f} to {most_mm:.0f} mm can be reached",
    Code.IK_LIMIT: "the target needs {joint} at {value_deg:.1f} deg, outside {lower_deg:.1f} to {upper_deg:.1f} deg",
    Code.STANCE: "the target needs another stance of the arm, {move_deg:.0f} deg of {joint} away",
    Code.SATURATED: "the target is {distance_mm:.0f} mm ahead of the arm and held at {limit_mm:.0f} mm",
    Code.NOT_A_POSE: "the target is not a finite rigid pose",
    Code.UNREACHED: "the arm comes no nearer to the target than {distance_mm:.0f} mm and {angle_deg:.0f} deg",
    Code.SINGULAR: "near a singular posture (condition {condition:.0f}): slowed to {share:.0%}",
    Code.OBSTACLE: "{first} is {distance_mm:.0f} mm from {second}: the arm comes no nearer",
    Code.POSITION: "{joint} would come to rest at {value:.4f} rad, outside {lower:.4f} to {upper:.4f} rad",
    Code.VELOCITY: "{joint} would move at {value:.3f} rad/s (limit {limit:.3f})",
    Code.ACCELERATION: "{joint} would accelerate at {value:.2f} rad/s² (limit {limit:.2f})",
    Code.JERK: "{joint} would jerk at {value:.1f} rad/s³ (limit {limit:.1f})",
    Code.INCONSISTENT: "{joint}: position, velocity and acceleration do not follow from the last command",
    Code.WORKSPACE: "the tool would come to rest {excess_mm:.1f} mm outside the workspace",
    Code.COLLISION: "{first} would come {distance_mm:.1f} mm near to {second} (limit {limit_mm:.1f} mm)",
    Code.NO_TRAJECTORY: "no jerk-limited trajectory to the target: {reason}",
    Code.COMMAND_TIMEOUT: "no command for {age_ms:.0f} ms (limit {limit_ms:.0f} ms): the driver stops the arm",
}


@dataclass(frozen=True, slots=True)
class Reason:
    """A code with its finished sentence, fit to be shown to the operator."""

    code: Code
    sentence: str


def reason(code: Code, **values: object) -> Reason:
    """The reason of a code; `values` fill the places of its sentence."""
    return Reason(code, SENTENCES[code].format(**values))
