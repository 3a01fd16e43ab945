"""Reasons why something was refused or stopped: every code with its sentence, in one table."""

from dataclasses import dataclass
from enum import StrEnum
from typing import Self

from common.messages.robot import NO_PAGE

MORE_PICTURES = (
    "Cure: let the operator's cameras give more pictures a second (fps and a fixed exposure_ms in [operator.cameras]), "
    "choose a quicker tracker, or set a longer safety.t_soft_ms"
)


class Code(StrEnum):
    """The short word of a refusal or of a state's reason; counted, sent in `RobotState`, stable over releases.

    `sentence` explains it to the operator, with fields for `reason` to fill in.
    """

    sentence: str

    def __new__(cls, value: str, sentence: str) -> Self:
        member = str.__new__(cls, value)
        member._value_, member.sentence = value, sentence
        return member

    OK = "ok", "the arm follows the hand"
    # the hand sample
    DUPLICATE = "duplicate", "sample {seq} arrived twice"
    OLD = "old", "sample {seq} is older than the newest, {newest}"
    STALE = "stale", "newest hand sample is {age_ms:.0f} ms old (limit {limit_ms:.0f} ms)"
    LINK_TOO_SLOW = (
        "link_too_slow",
        "the link takes {age_ms:.0f} ms, which is too slow: at most {most_ms:.0f} ms can be operated",
    )
    FUTURE = "future", "the sample was captured {ahead_ms:.0f} ms in the future: the clocks disagree"
    NOT_FINITE = "not_finite", "the {what} is not finite"
    LOST = "lost", "the hand is lost: {reason}"
    INITIALISING = "initialising", "tracking is initialising: {reason}"
    NO_WRIST = "no_wrist", "the sample lacks the point of the hand that the tool copies: {reason}"
    UNCERTAIN = "uncertain", "the {point} is known to {sigma_mm:.0f} mm only (limit {limit_mm:.0f} mm)"
    NO_COVARIANCE = (
        "no_covariance",
        "the sample states how well the hand is known, but no usable covariance of the {point}, which the tool copies",
    )
    JUMP = "jump", "the {point} jumped {distance_mm:.0f} mm in {interval_ms:.0f} ms"
    JUMPS = "jumps", "the {point} jumped in {count} samples in a row"
    NO_OFFSET = "no_offset", "the clock offset of the local site is not known yet"
    OLD_OFFSET = (
        "old_offset",
        "the clock offset of the local site was measured {age_ms:.0f} ms ago (limit {limit_ms:.0f} ms)",
    )
    # the way of the hand samples
    SAMPLES_OLD = (
        "samples_old",
        "hand samples are too old: a sample each {interval_ms:.0f} ms, {age_ms:.0f} ms old at arrival; the limit is "
        "{limit_ms:.0f} ms; network {network_ms:.0f} ms, clocks {clock_ms:.0f} ms, tracking {tracking_ms:.0f} ms. "
        "{cure}",
    )
    SAMPLES_RARE = (
        "samples_rare",
        "a hand sample comes only each {interval_ms:.0f} ms, but is obeyed for {limit_ms:.0f} ms at most. "
        + MORE_PICTURES,
    )
    SAMPLES_LOST = "samples_lost", "{loss:.1%} of the hand samples are lost on the way. {cure}"
    CLOCK_UNKNOWN = (
        "clock_unknown",
        "hand samples come, but without the offset of the clocks, so that their age is unknown: the local site gets no "
        "answer to its questions about the clock. The link loses nearly all, or its round trip is longer than 700 ms: "
        "check it with 'farhand doctor --link' at the local site",
    )
    # the lease
    NO_LEASE = (
        "no_lease",
        "nobody holds the lease of this cell: start a local site, which asks for it, "
        "or if one runs: farhand lease take",
    )
    NOT_HOLDER = (
        "not_holder",
        "{holder} holds the lease of this cell, and has to hand it over, release it, or let it expire",
    )
    OLD_LEASE = "old_lease", "lease {number} is no longer in force"
    LEASE_LOST = "lease_lost", "the lease of {holder} has ended"
    LEASE_HELD = "lease_held", "the lease of this cell is yours"
    LEASE_RELEASED = "lease_released", "the lease is given back"
    NOBODY_ASKS = "nobody_asks", "nobody asks for the lease, so it cannot be handed over"
    ASKER_CHANGED = (
        "asker_changed",
        "{asker} asks for the lease now, and the consent was for somebody else: nothing was handed over",
    )
    HANDED_OVER = "handed_over", "the lease went to {holder}"
    OPERATORS_ONLY = "operators_only", "maintenance may stop and reset the arm; the rest is the operator's"
    # the recording
    NO_RECORDER = (
        "no_recorder",
        "no recorder runs at the remote site; its administrator starts one: systemctl start farhand-record",
    )
    RECORD_FIXED = (
        "record_fixed",
        "the remote site's administrator begins and ends the recording (record.start = 'at_once' there)",
    )
    NOT_RECORDING = "not_recording", "nothing is recorded now: begin a recording first"
    TOO_MANY_EPISODES = (
        "too_many_episodes",
        "this recording has {most} episodes, as many as one may have: have it ended, and another begun",
    )
    RECORD_ASKED = "record_asked", "the recorder has been asked; the mark on the page shows what it does"
    # the session
    NOT_ENGAGED = "not_engaged", "not engaged yet"
    SITE_ENDED = "site_ended", "the remote site was asked to end"
    SITE_FAILED = "site_failed", "the remote site ends by itself: {cause}"
    SITE_STARTING = "site_starting", "the remote site is still starting"
    NO_HAND = "no_hand", "no hand sample has arrived yet"
    COLLECTING = "collecting", "{count} of {needed} good hand samples in a row"
    READY = "ready", "ready: waiting to be engaged"
    LATCHED = "latched", "disengaged, {cause}; engage again to continue"
    HELD_TOO_LONG = "held_too_long", "the arm was held for {limit_ms:.0f} ms, {cause}"
    AUTOMATIC_EXPIRED = "automatic_expired", "automatic engagement has expired; engage to begin"
    NEW_SESSION = "new_session", "{holder} operates now; engage to continue"
    RELEASED = "released", "disengaged on request"
    STOPPED = "stopped", "stopped by {operator}; reset it, then engage"
    RESET = "reset", "reset; engage to continue"
    UNSEEN = "unseen", "this came since, and was not shown when you asked: {now}. Look, then {act} again"
    NOT_HELD = "not_held", "the {input} is not held down"
    LET_GO_FIRST = (
        "let_go_first",
        "let go of the {input} first, then press it: an engagement that has ended never resumes by itself",
    )
    LET_GO = "let_go", "disengaged: the {input} was let go"
    ROBOT_NOT_READY = "robot_not_ready", "the robot is not ready: {reason}; reset it, then engage"
    UNSTEADY = (
        "unsteady",
        "the hand samples came late several times: the arm has waited for {held_ms:.0f} of {least_ms:.0f} ms",
    )
    MOVING = "moving", "the arm is still coming to rest"
    PAGE_SILENT = "page_silent", NO_PAGE
    PAUSED = "paused", "control paused for {paused_ms:.0f} ms (limit {limit_ms:.0f} ms)"
    SLOW = (
        "slow",
        "{who} has not kept up for a second: a turn takes {took_ms:.0f} ms (limit {limit_ms:.0f} ms); "
        "end what else runs on this machine, or take a faster one",
    )
    CLUTCHED = "clutched", "the clutch is held: the arm stays while you move your hand; let go to go on"
    CLUTCH_UNSEEN = (
        "clutch_unseen",
        "nobody saw the clutch let go, since the page was hidden, silent or late: press it again, and let go",
    )
    CLUTCH_SETTLING = (
        "clutch_settling",
        "the clutch is let go: the arm waits until your hand was calm for {calm_ms:.0f} ms",
    )
    FAULT = "fault", "{cause}; reset it, then engage"
    # the target
    OUT_OF_REACH = (
        "out_of_reach",
        "the target is out of reach: {distance_mm:.0f} mm from the robot's shoulder to its wrist, "
        "which reaches {least_mm:.0f} to {most_mm:.0f} mm",
    )
    IK_LIMIT = (
        "ik_limit",
        "the target needs {joint} at {value_deg:.1f} deg, outside {lower_deg:.1f} to {upper_deg:.1f} deg",
    )
    STANCE = "stance", "the target needs another IK configuration, {move_deg:.0f} deg of {joint} away"
    SATURATED = "saturated", "the target is {distance_mm:.0f} mm ahead of the arm and held at {limit_mm:.0f} mm"
    OUTSIDE_BOX = "outside_box", "the hand asks for {excess_mm:.0f} mm beyond the workspace: the tool stays at its edge"
    NOT_A_POSE = "not_a_pose", "the target is not a finite rigid pose"
    UNREACHED = "unreached", "the arm comes no nearer to the target than {distance_mm:.0f} mm and {angle_deg:.0f} deg"
    SINGULAR = "singular", "near a singular posture (condition {condition:.0f}): slowed to {fraction:.0%}"
    OBSTACLE = "obstacle", "{first} is {distance_mm:.0f} mm from {second}: the arm comes no nearer"
    # the command
    POSITION = "position", "{joint} would come to rest at {value:.4f} rad, outside {lower:.4f} to {upper:.4f} rad"
    VELOCITY = "velocity", "{joint} would move at {value:.3f} rad/s (limit {limit:.3f})"
    ACCELERATION = "acceleration", "{joint} would accelerate at {value:.2f} rad/s² (limit {limit:.2f})"
    JERK = "jerk", "{joint} would jerk at {value:.1f} rad/s³ (limit {limit:.1f})"
    INCONSISTENT = "inconsistent", "{joint}: position, velocity and acceleration do not follow from the last command"
    WORKSPACE = "workspace", "the tool would come to rest {excess_mm:.1f} mm outside the workspace"
    COLLISION = "collision", "{first} would come within {distance_mm:.1f} mm of {second} (limit {limit_mm:.1f} mm)"
    NO_TRAJECTORY = "no_trajectory", "no jerk-limited trajectory to the target: {reason}"
    COMMAND_TIMEOUT = (
        "command_timeout",
        "no command for {age_ms:.0f} ms (limit {limit_ms:.0f} ms): the driver stops the arm",
    )
    # a marker of a target
    MARKER_UNSEEN = "marker_unseen", "marker {marker} is covered, or out of all calibrated views"
    MARKER_ONE_VIEW = (
        "marker_one_view",
        "marker {marker} is seen by {view} alone: two calibrated views must see it, or the gripper's",
    )
    MARKER_FAR = (
        "marker_far",
        "only {view} sees marker {marker}, from {distance_mm:.0f} mm: bring the gripper within {limit_mm:.0f} mm",
    )
    MARKER_STALE = "marker_stale", "no new picture shows marker {marker}: the pictures are {age_ms:.0f} ms old"
    MARKER_DOUBLED = "marker_doubled", "{view} sees marker {marker} twice: take one of the two away"
    MARKER_CROWDED = (
        "marker_crowded",
        "{view} shows too many markers to look at marker {marker} in time: take those away that no target names",
    )
    MARKER_GRAZING = (
        "marker_grazing",
        "marker {marker} is seen at a grazing angle, {angle_deg:.0f} deg (limit {limit_deg:.0f} deg)",
    )
    MARKER_CONTRADICTED = (
        "marker_contradicted",
        "the views {views} disagree about marker {marker} by {miss_px:.1f} px: it moves, or a calibration is wrong",
    )
    MARKER_AMBIGUOUS = "marker_ambiguous", "marker {marker} may be turned in two ways as {views} see it"
    MARKER_UNCERTAIN = (
        "marker_uncertain",
        "the pose beside marker {marker} is known to {sigma_mm:.1f} mm and {sigma_deg:.1f} deg only: "
        "print a larger marker, or move a camera nearer",
    )
    MARKER_MOVED = "marker_moved", "marker {marker} has moved by {distance_mm:.0f} mm and {angle_deg:.0f} deg"
    # fine adjustment
    ASSIST_IDLE = "assist_idle", "the arm does not follow: engage it first"
    ASSIST_STEADYING = "assist_steadying", "marker {marker} has to stand still for {least_ms:.0f} ms"
    ASSIST_FAR = (
        "assist_far",
        "{target!r} is {distance_mm:.0f} mm and {angle_deg:.0f} deg away; "
        "the assist begins within {limit_mm:.0f} mm and {limit_deg:.0f} deg",
    )
    ASSIST_CLOSED = "assist_closed", "{target!r} is to be grasped: open the gripper first"
    ASSIST_OFFERED = (
        "assist_offered",
        "hold Assist: the tool will move {distance_mm:.0f} mm and {angle_deg:.0f} deg to {kind} {target!r}",
    )
    ASSIST_LEADING = (
        "assist_leading",
        "the tool moves to {kind} {target!r}: {distance_mm:.0f} mm and {angle_deg:.0f} deg are left",
    )
    ASSIST_THERE = (
        "assist_there",
        "the tool is where it has to be to {kind} {target!r}; let go of Assist to go on by hand",
    )
    ASSIST_LET_GO = "assist_let_go", "the assist has ended: A was let go"
    ASSIST_SILENT = "assist_silent", "the assist has ended: the page reported nothing for {silent_ms:.0f} ms"
    ASSIST_MOVED = "assist_moved", "the assist has ended: the hand moved by {distance_mm:.0f} mm"
    ASSIST_STUCK = (
        "assist_stuck",
        "the assist has ended: the tool comes no nearer, {distance_mm:.0f} mm and {angle_deg:.0f} deg are left; a "
        "limit or something in its way holds it back",
    )
    ASSIST_HALTED = "assist_halted", "the assist has ended: the arm was stopped"
    ASSIST_LOST = "assist_lost", "the assist has ended: {cause}"


@dataclass(frozen=True, slots=True)
class Reason:
    """A code with its finished sentence, fit to be shown to the operator."""

    code: Code
    sentence: str


def reason(code: Code, **values: object) -> Reason:
    """The reason of a code; `values` fill the fields of its sentence."""
    return Reason(code, code.sentence.format(**values))
