"""Markers that are seen without cameras, for tests of what is made of them."""

from common.geometry import Array
from common.messages.hand import Intent
from remote_site.assist.config import AssistConfig, AssistTargetConfig
from remote_site.assist.sighting import MarkerSighting
from remote_site.reasons import Reason

MARKER = 3
BLOCK = AssistTargetConfig(
    name="block", marker=MARKER, size_mm=40, kind="grasp", xyz_mm=(0, 0, 100), rpy_deg=(180, 0, 90)
)
CONFIG = AssistConfig(targets=(BLOCK,))
PRESSED, RELEASED = Intent(assist=BLOCK.name), Intent()


def seen(t_ns: int, base_T_marker: Array) -> MarkerSighting:
    """The marker, seen by two views."""
    return MarkerSighting(MARKER, t_ns, base_T_marker, None, ("front", "side"))


def refused(t_ns: int, why: Reason) -> MarkerSighting:
    """The marker's pose refused."""
    return MarkerSighting(MARKER, t_ns, None, why)
