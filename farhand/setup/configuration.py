"""The configuration that a setup writes: the local site's tables, each value with what it means."""

import json
from pathlib import Path

import msgspec

from common.cameras.settings import given
from common.errors import ConfigError
from common.text import escaped, toml_string
from farhand.deployment.schemas import schema_line
from farhand.setup.notes import SetupAnswers
from local_site.config import LocalConfig
from local_site.tracking.choice import TrackingConfig
from local_site.tracking.registry import tracker_kind, tracker_names

HEAD = """\
{schema}
# The operator's side with two cameras, written by farhand setup. Every key that there is: farhand config show local
# Start it with: farhand local --config {path}
# A remote site on another host: [links] remote = "tls/HOST:PORT", see docs/security.md
"""


def offered_methods() -> dict[str, str]:
    """The trackers of two cameras to choose from, and what each tracks; first the one that is usual."""
    names = sorted(tracker_names(), key=lambda name: (name != TrackingConfig().method, name))
    kinds = {name: tracker_kind(name) for name in names}
    return {name: kind.tracks for name, kind in kinds.items() if kind.scene != "textured"}


def configuration(answers: SetupAnswers, rig: Path, path: Path) -> str:
    """The TOML file of these answers, for a rig file; ConfigError for an answer that is missing."""
    if answers.left is None or answers.right is None or answers.method is None:
        raise ConfigError("cameras or tracker are not chosen yet; start farhand setup again")
    lines = [
        HEAD.format(schema=schema_line(LocalConfig), path=escaped(str(path))),
        "[operator]",
        f"left = {toml_string(answers.left)} # as the cameras see it",
        f"right = {toml_string(answers.right)}",
        f"rig = {toml_string(str(rig.resolve()))} # the calibration; it holds until a camera is touched",
        "",
    ]
    if settings := given(answers.settings):
        lines += ["[operator.cameras] # both are set to this, and refused where they do otherwise"]
        lines += [f"{key} = {_value(value)}" for key, value in settings.items()] + [""]
    lines += ["[tracking]", f"method = {toml_string(answers.method)} # {tracker_kind(answers.method).tracks}"]
    lines.append(
        f"profile_dir = {toml_string(str((path.parent / 'operators').resolve()))} # each operator's hand and forearm"
    )
    if has_sides(answers.method):
        lines += ["", f"[tracking.{answers.method}]", f"right_arm = {_value(answers.right_arm)} # which arm is tracked"]
    return "\n".join(lines) + "\n"


def has_sides(method: str) -> bool:
    """Return whether a tracker has to know which arm it tracks."""
    own = getattr(TrackingConfig(), method, None)
    return isinstance(own, msgspec.Struct) and "right_arm" in own.__struct_fields__


def _value(value: object) -> str:
    return toml_string(value) if isinstance(value, str) else json.dumps(value)
