"""The settings of both sites that a loopback needs for its tracker and its arm; pure."""

from collections.abc import Mapping
from pathlib import Path

from common.errors import ConfigError
from remote_site.drivers.config import EMULATED
from remote_site.kinematics.config import MODELS

A465, HUMANOID = "a465", "humanoid"
ARM_FILES: Mapping[str, Path | None] = {A465: None, HUMANOID: MODELS / HUMANOID / f"{HUMANOID}.toml"}
MARKERS, MONOCULAR = "markers", "monocular"
DEFAULT_MOTION = "pick_and_place"
# The camera is to the right of the operator, who faces the right of the picture: the camera's x points ahead of the
# operator, y down, z to the operator's left.
BASE_R_RIGHT_CAMERA = "[[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]]"


def check_combination(tracker: str, arm: str | None, motion: str, driver: str) -> None:
    """ConfigError when the driver cannot move the arm, or the operator of this tracker cannot make the motion."""
    if tracker == MONOCULAR and motion != DEFAULT_MOTION:
        raise ConfigError("the textured arm before one camera swings in its own way; leave --motion out")
    if arm == HUMANOID and driver == EMULATED:
        raise ConfigError(f"the driver {EMULATED} is the A465's; use simulated or kinematic for the {arm} arm")


def arm_file(arm: str | None) -> Path | None:
    """The remote site's file for an arm, None for the defaults; ConfigError when there is no such arm."""
    if arm is not None and arm not in ARM_FILES:
        raise ConfigError(f"there is no arm {arm!r}; choose one of: {', '.join(ARM_FILES)}")
    return ARM_FILES[arm] if arm is not None else None


def operator_settings(tracker: str) -> tuple[str, ...]:
    """The local site's settings for a simulated operator whom this tracker can follow, and who moves once engaged."""
    settings = "simulation.motion.begins=when_engaged", f"simulation.markers={str(tracker == MARKERS).lower()}"
    return (*settings, "simulation.textured=true") if tracker == MONOCULAR else settings


def operator_views(tracker: str) -> tuple[str, ...]:
    """The names of the operator's camera views, under which they are saved."""
    return ("operator_left",) if tracker == MONOCULAR else ("operator_left", "operator_right")


def arm_settings(tracker: str) -> tuple[str, ...]:
    """The remote site's mapping settings for the point that this tracker measures and the frame it measures in."""
    if tracker != MONOCULAR:
        return ()
    return "mapping.point=palm", f"mapping.base_R_operator={BASE_R_RIGHT_CAMERA}"
