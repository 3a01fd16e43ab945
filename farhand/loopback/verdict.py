"""Verdict on a loopback run, its last line: good, broken, or this machine was too slow or cannot render; and why."""

from collections.abc import Sequence

from common.errors import CameraError, ProcessError
from common.messages.robot import FOLLOWING, RobotState
from farhand.loopback.figures import Figures, followed_share, per_second
from farhand.loopback.recorder import Record
from remote_site.drivers.franka.simulator import SLOWER
from remote_site.reasons import Code

LITTLE = 0.9  # of the time; a machine that keeps up follows for 95 % and more
ENOUGH_PICTURES = 0.8  # of those that the simulated cameras expose
SLOW_VIEW, OLD_MS = 0.5, 300.0  # of the pictures a second that are asked for; an age from which none counts as live
LATE = (Code.SAMPLES_OLD, Code.SAMPLES_RARE)
MAX_FOLLOW_MM = 50.0
TRY_LESS = "End what else runs on it, or try less: --headless, --tracker markers, --driver kinematic"
VIEW_PX = (64, 48)


def praise(figures: Figures) -> str:
    """The last line of a run in which all is good."""
    took_ms = figures["capture_to_command_ms"]["p50"]
    command = "" if took_ms is None else f", {took_ms:.0f} ms from exposure to command"
    share, off_mm = figures["followed_share"], figures["follow_mm"]["mean"]
    good = f"good: the arm followed for {share:.1%} of the time, {off_mm:.1f} mm off the hand{command}"
    return f"{good}; {figures['slow_views']}" if figures["slow_views"] else good


def slow_views(video: Figures, fps: float) -> str | None:
    """Say which of the cell's views came too rarely or too late on this machine, which asked for `fps` of each."""
    slow = []
    for name, view in video.items():
        age_ms = view["glass_to_glass_ms"]["p95"]
        if age_ms is not None and (view["fps"] < SLOW_VIEW * fps or age_ms > OLD_MS):
            slow.append(f"{name.replace('_', ' ')} {view['fps']:.0f} of {fps:.0f} a second, {age_ms:.0f} ms old")
    if not slow:
        return None
    return f"but it was too slow for pictures of the cell: {'; '.join(slow)}. End what else runs on this machine"


def check_followed(figures: Figures) -> None:
    """ProcessError when the tool did not follow the hand, or stopped following it."""
    if figures["stopped"] is not None:
        raise ProcessError(
            f"the arm followed for {figures['followed_share']:.0%} of the time, then: {figures['stopped']}"
        )
    mean = figures["follow_mm"]["mean"]
    if mean is None:
        raise ProcessError("the arm was never engaged")
    if mean > MAX_FOLLOW_MM:
        raise ProcessError(f"the arm does not follow: its tool is {mean:.0f} mm off on average")


def judged_failure(failure: ProcessError, slowness: str | None) -> ProcessError:
    """A run's failure: broken, unless this machine was too slow, which the last line then says."""
    return ProcessError(f"{failure}\n{slowness}" if slowness else f"broken: {failure}")


def too_slow(record: Record, fps: float, warnings: Sequence[str]) -> str | None:
    """Say what ran late where the arm followed little or stopped, and what to do; None where nothing did.

    `fps` is the rate of the simulated operator's pictures, `warnings` are what the sites have logged.
    """
    states, exposures_ns = list(record.states), [hand.capture_ns for hand in record.hands]
    if followed_share(states) >= LITTLE and states[-1].state in FOLLOWING:
        return None
    late = [*_samples(states), *_pictures(per_second(exposures_ns), fps), *_simulator(warnings)]
    return f"this machine was too slow: {'; '.join(late)}. {TRY_LESS}" if late else None


def _samples(states: Sequence[RobotState]) -> list[str]:
    """List how old the hand samples became: both sites are on this machine, so it is not the network."""
    links = [(state.hand_link, state.age_limit_ms) for state in states if state.hand_link is not None]
    ages = [(link.age_ms, limit_ms) for link, limit_ms in links if link.code in LATE and link.age_ms is not None]
    if not ages:
        return []
    age_ms, limit_ms = max(ages)
    return [f"the tracking was late, with hand samples {age_ms:.0f} ms old (limit {limit_ms:.0f} ms)"]


def _pictures(tracked: float, exposed: float) -> list[str]:
    few = 0.0 < tracked < ENOUGH_PICTURES * exposed
    return [f"it tracked {tracked:.0f} of {exposed:.0f} pictures a second"] if few else []


def _simulator(warnings: Sequence[str]) -> list[str]:
    return [SLOWER] if any(SLOWER in warning for warning in warnings) else []


def rendering_problem() -> str:
    """Why nothing can be rendered off screen, with the packages on a line of their own; empty where it works."""
    try:
        import mujoco  # noqa: PLC0415  # only once a run with simulated views has failed
    except ImportError as error:
        return f"simulated views need MuJoCo ({error})\ninstall it: pip install 'farhand[sim]'"
    from remote_site.video.cell_cameras import CURE, OffScreen  # noqa: PLC0415  # the same

    try:
        OffScreen(mujoco.MjModel.from_xml_string("<mujoco/>"), *VIEW_PX).close()
    except CameraError as error:
        why = str(error).removesuffix(f"; {CURE}")
        return f"{why}\ninstall what is missing, {CURE}"
    return ""


def explained(failure: ProcessError, *, views_are_simulated: bool) -> ProcessError:
    """Return what to say instead of a failure where views cannot be rendered; else the failure itself."""
    problem = rendering_problem() if views_are_simulated else ""
    return ProcessError(problem) if problem else failure
