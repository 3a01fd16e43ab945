"""The arm that the robot's side loads, and how long it may take to stop; probes, and pure checks."""

from collections.abc import Sequence
from dataclasses import dataclass

from farhand.doctor.findings import Finding, error, ok, warning
from remote_site.config import RemoteConfig
from remote_site.kinematics.config import UNSTATED_JERK_RAD_S3


def probe_robot(config: RemoteConfig) -> list[tuple[str, str, str]]:
    """Look up the driver and load the arm as the remote site does; returns (part, sentence, cure) of each mistake."""
    try:
        from remote_site.runtime.checks import find_mistakes  # noqa: PLC0415  # the doctor also examines hosts without its libraries
    except ImportError as wrong:
        cure = "install Farhand again: pip install -e '.[sim]'"
        return [("robot", f"the arm cannot be loaded: {wrong}", cure)]
    return [(mistake.part, mistake.sentence, mistake.cure) for mistake in find_mistakes(config)]


def check_robot(model: str, driver: str, mistakes: Sequence[tuple[str, str, str]]) -> list[Finding]:
    """All that the remote site loads of its robot can be loaded; each mistake (part, sentence, cure) is a finding."""
    if not mistakes:
        return [
            ok(
                "robot",
                f"the model {model} loads, its start posture is valid; driver {driver}, whose robot was not asked",
            )
        ]
    return [error(part, sentence, cure) for part, sentence, cure in mistakes]


def probe_unguarded(config: RemoteConfig) -> tuple[str, ...]:
    """List what the configuration of an arm that can be loaded leaves unguarded, part by part."""
    from remote_site.runtime.checks import find_unguarded  # noqa: PLC0415  # the doctor also examines hosts without its libraries

    return find_unguarded(config)


def check_guard(parts: Sequence[str]) -> Finding:
    """Report what is not guarded; a warning where it could be."""
    from remote_site.safety.unguarded import in_one_line  # noqa: PLC0415  # as above

    sentence = f"not guarded: {in_one_line(parts)}"
    if not parts:
        return ok("guard", sentence)
    cure = "give the boxes of the cell, capsules, and a box of the tool with sides where it has to stop: docs/safety.md"
    return warning("guard", sentence, cure)


@dataclass(frozen=True, slots=True)
class StopFacts:
    """The joint with the longest stop, how long that takes and may take, and the joints whose file states no jerk."""

    joint: str
    takes_ms: float
    may_take_ms: float
    urdf: str
    without_jerk: tuple[str, ...] = ()


def probe_stops(config: RemoteConfig) -> StopFacts:
    """Compute the stops from the limits of an arm that can be loaded."""
    from remote_site.kinematics.limits import load_arm  # noqa: PLC0415  # the doctor also examines hosts without its libraries
    from remote_site.safety.stop_bound import longest_stops  # noqa: PLC0415  # as above

    model, limits = load_arm(config.robot)
    stops = longest_stops(limits)
    slowest = limits.names[stops.index(max(stops))]
    allowed_ms = config.safety.longest_stop_ms
    return StopFacts(slowest, 1e3 * max(stops), allowed_ms, str(config.robot.urdf), model.without_jerk)


def check_stops(facts: StopFacts) -> Finding:
    """The stops are as long as they are; an arm whose file states no jerk may be given more than it can bear."""
    sentence = f"a stop takes {facts.takes_ms:.0f} ms at most ({facts.joint}), of {facts.may_take_ms:g} allowed"
    if not facts.without_jerk:
        return ok("stopping", sentence)
    assumed = (
        f"{facts.urdf} states no jerk for {', '.join(facts.without_jerk)}, so {UNSTATED_JERK_RAD_S3:g} rad/s³ counts"
    )
    cure = 'add jerk="…" to their <limit>, as the robot\'s maker states it, or tighten robot.jerk_rad_s3'
    return warning("stopping", f"{assumed}; {sentence}", cure)
