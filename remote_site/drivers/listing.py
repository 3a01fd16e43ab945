"""The drivers that are installed: where each comes from, what it says of itself, why it cannot be used."""

import inspect
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass
from importlib.metadata import EntryPoint, entry_points
from importlib.util import find_spec

from remote_site.drivers.registry import GROUP

OWN = "farhand"
OWN_NEEDS = {  # in processes of their own
    "simulated": ("mujoco", "MuJoCo is not installed: pip install 'farhand[sim]'"),
    "franka": ("pylibfranka", "pylibfranka is not installed: pip install 'farhand[franka]'"),
}
UNDESCRIBED = "no description: its factory has no docstring"


@dataclass(frozen=True, slots=True)
class ListedDriver:
    """A driver by its name: the package that provides it, its one-line description, what is `missing` (or nothing)."""

    name: str
    origin: str
    description: str
    missing: str = ""

    def __str__(self) -> str:
        words = self.description or f"CANNOT BE USED: {self.missing}"
        also = f"; CANNOT BE USED: {self.missing}" if self.description and self.missing else ""
        return f"{self.name} ({self.origin}): {words}{also}"


def installed_drivers() -> list[ListedDriver]:
    """Every driver that an installed package provides, by name; each is loaded, and none is made."""
    return list_drivers(entry_points(group=GROUP))


def list_drivers(points: Iterable[EntryPoint]) -> list[ListedDriver]:
    """The drivers of these entry points, by name; of one name in two packages neither is sure to be used."""
    ordered = sorted(points, key=lambda point: point.name)
    named = Counter(point.name for point in ordered)
    return [_listed(point, shared=named[point.name] > 1) for point in ordered]


def _listed(point: EntryPoint, *, shared: bool) -> ListedDriver:
    origin = origin_of(point)
    try:
        factory = point.load()
    except (Exception, SystemExit) as error:  # an installed driver may raise anything
        return ListedDriver(point.name, origin, "", f"{point.value} raised {type(error).__name__}: {error}")
    if not callable(factory):
        return ListedDriver(point.name, origin, "", f"{point.value} cannot be called: it is no factory of drivers")
    description = (inspect.getdoc(factory) or UNDESCRIBED).partition("\n")[0]
    missing = [f"another package provides {point.name} too: uninstall one of them"] if shared else []
    if _is_own(point) and (need := missing_package(point.name)):
        missing.append(need)
    return ListedDriver(point.name, origin, description, "; ".join(missing))


def missing_package(name: str) -> str:
    """Say what a driver of Farhand's own lacks on this machine, and how to install it; "" for nothing."""
    need = OWN_NEEDS.get(name)
    return need[1] if need is not None and find_spec(need[0]) is None else ""


def _is_own(point: EntryPoint) -> bool:
    return point.dist is not None and point.dist.name == OWN


def origin_of(point: EntryPoint) -> str:
    """Say which package provides an entry point, and whether it is Farhand itself."""
    if point.dist is None:
        return "of an unknown package"
    return f"{'ships with' if _is_own(point) else 'from'} {point.dist.name} {point.dist.version}"
