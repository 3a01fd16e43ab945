"""Which simulated operator and which arm a loopback brings together, as settings of both sites; pure."""

from collections.abc import Mapping
from pathlib import Path

from common.errors import ConfigError
from common.text import instead_of
from local_site.tracking.registry import Scene, tracker_kind
from remote_site.drivers.config import C500C, DRIVER_FILES, FRANKA
from remote_site.kinematics.config import MODELS

A465, HUMANOID, FR3 = "a465", "humanoid", "fr3"
ARM_FILES: Mapping[str, Path | None] = {
    A465: None,
    HUMANOID: MODELS / HUMANOID / f"{HUMANOID}.toml",
    FR3: DRIVER_FILES[FRANKA],
}
ARM_OF_DRIVER = {C500C: A465, FRANKA: FR3}
MONOCULAR = "monocular"
EMPTY_S = 3.0  # 38 pairs, of which the tracker learns the room, take 2.6 s of it
ROOM_FPS = 15.0  # an office in colour takes half as long to draw as the arm in it to track, on the same processors
USUAL_MOTION = "pick_and_place"
# One camera at the right of an operator who looks to the right of the picture: its x is ahead, y down, z to the left.
FROM_THE_RIGHT = "[[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]]"


def scene_of(tracker: str) -> Scene:
    """Return what this tracker needs before its cameras; ConfigError without such a tracker."""
    try:
        return tracker_kind(tracker).scene
    except ConfigError as error:
        raise ConfigError(f"tracking.method: {error}") from error


def check_scenario(tracker: str, arm: str | None, motion: str, driver: str) -> None:
    """ConfigError for an arm that this driver cannot move, and for a motion that the simulated operator cannot make."""
    if scene_of(tracker) == "textured" and motion != USUAL_MOTION:
        raise ConfigError("the textured arm before one camera has a motion of its own; leave --motion out")
    own = ARM_OF_DRIVER.get(driver)
    if arm is not None and own is not None and arm != own:
        raise ConfigError(f"the driver {driver} is the {own}'s; use simulated or kinematic for the {arm} arm")


def arm_file(arm: str | None, driver: str | None) -> Path | None:
    """The remote site's file for an arm, or a driver's own; None for the defaults; ConfigError without such an arm."""
    if arm is None:
        return DRIVER_FILES.get(driver or "")
    if arm not in ARM_FILES:
        raise ConfigError(f"there is no arm {arm!r}; {instead_of(arm, ARM_FILES)}")
    return ARM_FILES[arm]


def operator_settings(tracker: str) -> tuple[str, ...]:
    """The local site's settings for an operator that this tracker can follow, who starts to move at the engagement."""
    scene = scene_of(tracker)
    settings = "simulation.motion.begins=when_engaged", f"simulation.markers={str(scene == 'markers').lower()}"
    dressed = {"textured": "simulation.textured=true", "room": "simulation.room.scene=office"}
    return (*settings, dressed[scene]) if scene in dressed else settings


def operator_wishes(tracker: str) -> tuple[str, ...]:
    """The local site's settings with which this tracker begins best."""
    if scene_of(tracker) == "room":
        return f"simulation.room.empty_s={EMPTY_S}", f"simulation.fps={ROOM_FPS}"
    return ("tracking.monocular.start.by=silhouette",) if tracker == MONOCULAR else ()


def operator_views(tracker: str) -> tuple[str, ...]:
    """The names of the operator's views as they are saved."""
    return ("operator_left",) if scene_of(tracker) == "textured" else ("operator_left", "operator_right")


def arm_settings(tracker: str) -> tuple[str, ...]:
    """The remote site's settings for what this tracker measures, and for where its cameras are."""
    if scene_of(tracker) != "textured":
        return ()
    return "mapping.point=palm", f"mapping.base_R_operator={FROM_THE_RIGHT}"
