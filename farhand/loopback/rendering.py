"""Runs that fail because the cell's views cannot be rendered here: the last lines then name what to install."""

from common.errors import CameraError, ProcessError

VIEW_PX = (64, 48)


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
