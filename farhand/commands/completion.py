"""The names that the shell completes: of drivers, motions, configurations, keys, values; loaded only when it asks."""

from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Any, get_args

import typer


def driver_names(incomplete: str) -> list[str]:
    """The drivers that are installed."""
    from importlib.metadata import entry_points

    from remote_site.drivers.registry import GROUP

    return _beginning(incomplete, entry_points(group=GROUP).names)


def tracker_names(incomplete: str) -> list[str]:
    """The trackers that are installed."""
    from local_site.tracking.registry import tracker_names as names

    return _beginning(incomplete, names())


def motion_names(incomplete: str) -> list[str]:
    """List the motions of the simulated operator that begin so."""
    from local_site.simulation.config import MotionName

    return _beginning(incomplete, get_args(MotionName))


def model_names(incomplete: str) -> list[str]:
    """The arms that Farhand brings; the key may name a file instead."""
    from remote_site.kinematics.config import MODELS, is_built_in

    return _beginning(incomplete, filter(is_built_in, (folder.name for folder in MODELS.iterdir())))


def arm_names(incomplete: str) -> list[str]:
    """The arms of the loopback."""
    from farhand.loopback.scenario import ARM_FILES

    return _beginning(incomplete, ARM_FILES)


def experiment_names(incomplete: str) -> list[str]:
    """The experiments, and all of them."""
    from common.errors import NotInstalledError
    from farhand.commands.laboratory import experiments

    try:
        found = experiments()
    except NotInstalledError:
        return []
    return _beginning(incomplete, [*found.NAMES, found.ALL])


def configuration_names(incomplete: str) -> list[str]:
    """The configurations that are shipped."""
    from farhand.deployment.shipped import NAMES

    return _beginning(incomplete, NAMES)


def setting_words(context: typer.Context, incomplete: str) -> list[str]:
    """The keys of the sites whose settings a command takes, as table.key=, and after it the values that are known.

    Those of both sites where it may be either.
    """
    from farhand.deployment.kinds import KINDS
    from farhand.deployment.mix_ups import COMMANDS

    words = context.command_path.split()[1:]
    taken = TAKEN_BY.get(" ".join(words), words[0] if words else "")
    kinds = [kind for kind in KINDS if COMMANDS[kind] == taken] or [kind for kind in KINDS if COMMANDS[kind] in SITES]
    types = {key: expected for kind in kinds for key, expected in _keys(kind, "")}
    key, given, begun = incomplete.partition("=")
    if not given:
        return _beginning(incomplete, (f"{key}=" for key in types))
    values = NAMED[key](begun) if key in NAMED and key in types else _values(types.get(key), begun)
    return [f"{key}={value}" for value in values]


def _keys(struct: type[Any], above: str) -> Iterator[tuple[str, Any]]:
    """Every key below a table, dotted, with its type."""
    import msgspec

    for field in msgspec.structs.fields(struct):
        key = f"{above}{field.encode_name}"
        if isinstance(field.type, type) and issubclass(field.type, msgspec.Struct):
            yield from _keys(field.type, f"{key}.")
        else:
            yield key, field.type


def _values(expected: Any, begun: str) -> list[str]:
    """The values of a key of that type that begin so; none where it names none."""
    from common.config.choices import allowed_values, alternatives

    switch = ("true", "false") if bool in alternatives(expected) else ()
    return _beginning(begun, [*switch, *map(str, allowed_values(expected))])


NAMED: Mapping[str, Callable[[str], list[str]]] = {  # keys whose values are names that are installed
    "driver.name": driver_names,
    "tracking.method": tracker_names,
    "robot.model": model_names,
}
SITES = "remote", "local"
TAKEN_BY = {  # whose settings a command takes that is not named after them; others may take those of both sites
    "limits": "remote",
    "driver test": "remote",
    "track": "local",
    "teach run": "local",
    "replay": "local",
}


def _beginning(incomplete: str, names: Iterable[str]) -> list[str]:
    return sorted({name for name in names if name.startswith(incomplete)})
