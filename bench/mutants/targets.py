"""Which files are changed, how often, and which tests have to notice."""

from pathlib import Path
from typing import NamedTuple

REMOTE, TESTS = Path("remote_site"), Path("tests/remote_site")
SESSION = (TESTS / "session",)
TELEOP = TESTS / "teleop"
VALIDATION = tuple(
    TELEOP / f"test_{name}.py" for name in ("sample_validator", "certainty", "turn_certainty", "orientation_gate")
)
TURNS = tuple(TELEOP / f"test_{name}.py" for name in ("followed_orientation", "turning_target"))
MAPPING = tuple(
    TELEOP / f"test_{name}.py"
    for name in ("mapping", "clutch", "tool_target", "turning_target", "short_hold", "humanoid")
)
PIPELINE = (
    *(
        TELEOP / f"test_{name}.py"
        for name in ("pipeline", "lease_in_pipeline", "gripper_toggles", "gripper_baseline", "clutch", "replay")
    ),
    TESTS / "test_surviving_changes.py",
)
PAGE = (TESTS / "session" / "test_operator_page.py", TELEOP / "test_operator_settings.py")
SUPERVISOR = (TESTS / "drivers" / "supervisor",)
GUARD = (TESTS / "safety", TESTS / "test_surviving_changes.py")
SEAT = (Path("tests/local_site/console"),)


class Target(NamedTuple):
    """A file, how many mutants are made of it, and the tests that are run, the quickest first."""

    path: Path
    mutants: int
    tests: tuple[Path, ...]


TARGETS = (
    Target(REMOTE / "session" / "state_machine.py", 24, SESSION),
    Target(REMOTE / "session" / "engagement_intent.py", 8, SESSION),
    Target(REMOTE / "session" / "hand_signal.py", 8, SESSION),
    Target(REMOTE / "session" / "requests.py", 6, SESSION),
    Target(REMOTE / "session" / "fault_latch.py", 6, SESSION),
    Target(REMOTE / "session" / "lease.py", 12, SESSION),
    Target(REMOTE / "session" / "operator_page.py", 6, PAGE),
    Target(REMOTE / "teleop" / "sample_validator.py", 14, VALIDATION),
    Target(REMOTE / "teleop" / "certainty.py", 5, VALIDATION),
    Target(REMOTE / "teleop" / "turn_certainty.py", 6, VALIDATION),
    Target(REMOTE / "teleop" / "orientation_gate.py", 4, VALIDATION),
    Target(REMOTE / "teleop" / "followed_orientation.py", 10, TURNS),
    Target(Path("common/mapping/relative_mapping.py"), 8, MAPPING),
    Target(Path("common/mapping/rotation_mapping.py"), 4, MAPPING),
    Target(REMOTE / "teleop" / "tool_target.py", 4, MAPPING),
    Target(REMOTE / "teleop" / "gripper_toggles.py", 6, PIPELINE),
    Target(REMOTE / "teleop" / "sample_receiver.py", 3, PIPELINE),
    Target(REMOTE / "teleop" / "pipeline.py", 10, PIPELINE),
    Target(REMOTE / "drivers" / "supervisor" / "supervisor.py", 14, SUPERVISOR),
    Target(REMOTE / "drivers" / "supervisor" / "commanded_motion.py", 5, SUPERVISOR),
    Target(REMOTE / "drivers" / "supervisor" / "write_scheduler.py", 6, SUPERVISOR),
    Target(REMOTE / "drivers" / "supervisor" / "writer.py", 8, SUPERVISOR),
    Target(REMOTE / "drivers" / "supervisor" / "stop_plan.py", 4, SUPERVISOR),
    Target(REMOTE / "drivers" / "supervisor" / "reading_check.py", 10, SUPERVISOR),
    Target(REMOTE / "drivers" / "supervisor" / "following_check.py", 6, SUPERVISOR),
    Target(REMOTE / "safety" / "guard.py", 10, GUARD),
    Target(REMOTE / "safety" / "clearance.py", 6, GUARD),
    Target(REMOTE / "safety" / "stopping.py", 8, GUARD),
    Target(Path("local_site/console/model/seat.py"), 8, SEAT),
)
