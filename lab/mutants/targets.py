"""Which files are changed, how often, and which tests have to notice."""

from pathlib import Path
from typing import NamedTuple

REMOTE, LOCAL, COMMON, MAPPED = Path("remote_site"), Path("local_site"), Path("common"), Path("common/mapping")
TESTS, LOCAL_TESTS = Path("tests/remote_site"), Path("tests/local_site")
TELEOP, MOTION = TESTS / "teleop", TESTS / "motion"


class Target(NamedTuple):
    """A file, how many mutants are made of it, and the tests that are run, the quickest first.

    What `tests` do not notice, `EDGES` have to: one more of those asks for no other mutant to be tried anew.
    """

    path: Path
    mutants: int
    tests: tuple[Path, ...]


def _tests(folder: Path, *names: str) -> tuple[Path, ...]:
    return tuple(folder / f"test_{name}.py" for name in names)


EDGES = (TESTS / "test_changes_at_the_edges.py",)
SURVIVING = TESTS / "test_surviving_changes.py"
SESSION = (TESTS / "session",)
LINK = (
    *_tests(TESTS / "session", "link_ages", "hand_link", "age_limit", "hold", "longest_hold"),
    TELEOP / "test_far_link.py",
)
PAGE = (*SESSION, TELEOP / "test_operator_settings.py")
VALIDATION = _tests(TELEOP, "sample_validator", "certainty", "turn_certainty", "orientation_gate")
TURNS = _tests(TELEOP, "followed_orientation", "turning_target")
MAPPING = _tests(
    TELEOP, "leash", "mapping", "new_origins", "tool_target", "target_time", "turning_target", "short_hold", "humanoid"
)
PIPELINE = (
    *_tests(
        TELEOP,
        "pipeline",
        "lease_in_pipeline",
        "gripper_toggles",
        "gripper_baseline",
        "clutch",
        "new_origins",
        "replay",
    ),
    SURVIVING,
    TESTS / "assist" / "test_assist_in_pipeline.py",
)
FOLLOWING = (MOTION, *_tests(TELEOP, "catch_up", "quick_aims", "slowed_arm", "other_arms"), SURVIVING)
KINEMATICS = (TESTS / "kinematics", *_tests(TELEOP, "slowed_arm", "other_arms"))
STOPS = (
    *_tests(TESTS / "safety", "stop_bound", "stop_figures", "stopping"),
    TESTS / "kinematics" / "test_limits_factor.py",
    TESTS / "runtime" / "test_checks.py",
)
SILENCES = _tests(TESTS / "safety", "silence", "turn_watch")
GUARD = (TESTS / "safety", MOTION / "test_planner.py", SURVIVING)
SUPERVISOR = (TESTS / "drivers" / "supervisor",)
POSITION_ARM = (TESTS / "drivers" / "position_arm",)
DRIVERS, FRANKA = TESTS / "drivers", TESTS / "drivers" / "franka"
GRIPPING = (DRIVERS / "supervisor" / "test_gripper_orders.py", FRANKA / "test_gripper_orders.py", *POSITION_ARM)
STEPS = (*POSITION_ARM, DRIVERS / "c500c" / "test_setpoints.py")
DRIVER_LINK = (DRIVERS / "test_driver_link.py", TESTS / "runtime" / "test_control_loop.py")
CONTROL = _tests(TESTS / "runtime", "control_loop", "inbox", "wrong_reading")
CLOCKS = (*_tests(Path("tests/common"), "steady_time", "clock_offset"), TESTS / "runtime" / "test_inbox.py")
SETPOINTS = _tests(FRANKA, "setpoint_filter", "robot_limits", "franka_driver")
ASSIST = (TESTS / "assist",)
SAMPLES = (LOCAL_TESTS / "samples",)
SEAT = (LOCAL_TESTS / "console",)
LATCH = (Path("tests/common/messages/test_clutch_latch.py"), TESTS / "session" / "test_session_mutations.py")
PROGRAMMED = (LOCAL_TESTS / "programmed", *_tests(Path("tests/farhand/replay"), "recorded_tool_path", "path_run"))
AUTHORITY = (LOCAL_TESTS / "authority",)


def _targets(folder: Path, tests: tuple[Path, ...], **mutants: int) -> tuple[Target, ...]:
    return tuple(Target(folder / f"{name}.py", count, tests) for name, count in mutants.items())


TARGETS = (
    *_targets(
        REMOTE / "session",
        SESSION,
        state_machine=24,
        engagement_intent=8,
        hand_signal=8,
        requests=6,
        fault_latch=6,
        lease=12,
        hold=6,
    ),
    *_targets(REMOTE / "session", LINK, age_limit=8, hand_link_meter=8, hand_link_verdict=6, link_ages=6),
    *_targets(REMOTE / "session", PAGE, operator_page=14),
    *_targets(REMOTE / "teleop", VALIDATION, sample_validator=18, certainty=5, turn_certainty=6),
    *_targets(REMOTE / "teleop", TURNS, followed_orientation=10),
    *_targets(MAPPED, MAPPING, relative_mapping=8, rotation_mapping=4),
    *_targets(REMOTE / "teleop", MAPPING, tool_target=30, hold_offset=6, mapping=4),
    *_targets(REMOTE / "teleop", PIPELINE, gripper_toggles=6, sample_receiver=3, pipeline=10),
    *_targets(
        REMOTE / "motion",
        FOLLOWING,
        catch_up=6,
        delayed_target=10,
        estimator=12,
        gains=6,
        jerk_limited=8,
        joint_path=8,
        moving_frame=8,
        planner=8,
        target_path=8,
        target_predictor=14,
        target_tracker=14,
        tool_shift=6,
        waiting_target=18,
    ),
    *_targets(
        REMOTE / "kinematics",
        KINEMATICS,
        limits=10,
        dexterity=5,
        inverse=12,
        differential=10,
        swivel=6,
        upright_arm=8,
    ),
    *_targets(
        REMOTE / "safety",
        GUARD,
        guard=10,
        clearance=8,
        stopping=8,
        collision=8,
        collision_avoidance=10,
        workspace_box=4,
    ),
    *_targets(REMOTE / "safety", SILENCES, silence=8, turn_watch=8),
    *_targets(REMOTE / "safety", STOPS, stop_bound=4, stop_figures=4),
    *_targets(
        REMOTE / "drivers" / "supervisor",
        SUPERVISOR,
        supervisor=14,
        commanded_motion=5,
        write_scheduler=6,
        writer=10,
        stop_plan=4,
        reading_check=20,
        following_check=6,
        grip=6,
        orders=4,
        watched_driver=6,
    ),
    *_targets(
        REMOTE / "drivers" / "position_arm",
        POSITION_ARM,
        driver=10,
        arm_stop=14,
        calls=8,
        threaded_calls=8,
        readings=7,
    ),
    *_targets(REMOTE / "drivers" / "franka", SETPOINTS, setpoint_filter=6),
    *_targets(
        REMOTE / "assist",
        ASSIST,
        assist=20,
        leading=5,
        marker_watch=8,
        standing_marker=6,
    ),
    *_targets(REMOTE / "assist", ASSIST, detection=6, marker_pose=8),
    *_targets(REMOTE / "session", (*SESSION, SURVIVING, *CONTROL), halts=8, samples=8),
    *_targets(REMOTE / "runtime", CONTROL, control=10, driven_pipeline=6),
    *_targets(REMOTE / "drivers", GRIPPING, gripper_orders=10),
    *_targets(REMOTE / "drivers", STEPS, position_steps=6),
    *_targets(REMOTE / "drivers", DRIVER_LINK, link=12),
    *_targets(REMOTE / "drivers" / "c500c", (DRIVERS / "c500c",), driver=8, exchange=8, port=4, protocol=8),
    *_targets(REMOTE / "drivers" / "franka", (FRANKA,), arm_loop=10, gripper_loop=8, robot_watch=8, driver=8),
    *_targets(COMMON, CLOCKS, steady_time=12, clock=10),
    *_targets(COMMON / "messages", LATCH, clutch_latch=6),
    *_targets(LOCAL / "samples", SAMPLES, hand_sample=10, smoothing=10),
    *_targets(LOCAL / "console" / "model", SEAT, seat=8),
    *_targets(LOCAL / "programmed", PROGRAMMED, path_run=10, path_progress=8, path_runs=8, led_hand=5, approach=3),
    *_targets(LOCAL / "authority", AUTHORITY, lease_policy=6),
)
