"""Reads the conformance vectors of docs/c500c-vectors, as their README describes them."""

from pathlib import Path
from typing import Literal

import msgspec

FOLDER = Path(__file__).parents[4] / "docs" / "c500c-vectors"

Joints = tuple[int, int, int, int, int, int]
FlagName = Literal["active", "moving", "arm power", "emergency stop", "gripper busy"]
ByHand = Literal["press emergency stop", "release emergency stop", "switch arm power off", "switch arm power on"]


class _Table(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    says: str


class Checksum(_Table, frozen=True, kw_only=True):
    """Bytes in hexadecimal, with their checksum as a number and as it goes over the line."""

    bytes: str
    crc: str
    on_the_line: str


class FrameVector(_Table, frozen=True, kw_only=True):
    """A frame in hexadecimal, and the numbers that it holds; None for those that its kind does not have."""

    sender: Literal["host", "controller"] = msgspec.field(name="from")
    kind: Literal["poll", "activate", "setpoint", "halt", "state"]
    sequence: int
    hex: str
    count: int | None = None
    joints_urad: Joints | None = None
    period_ms: int | None = None
    gripper: int | None = None
    force_percent: int | None = None
    flags: int | None = None
    fault: int | None = None
    queued: int | None = None
    activation: int | None = None
    begun: int | None = None
    taken: int | None = None
    opening_10um: int | None = None


class Damaged(_Table, frozen=True, kw_only=True):
    """Bytes in hexadecimal that hold no frame."""

    hex: str


class Frames(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """What frames.toml holds."""

    crc: list[Checksum]
    frame: list[FrameVector]
    damaged: list[Damaged]


class Step(_Table, frozen=True, kw_only=True):
    """What the host sends or a hand does, and what the answer must be; None where nothing is asked of it."""

    at_ms: int
    send: str = ""
    do: ByHand | None = None
    expect: str | None = None
    flags_set: frozenset[FlagName] = frozenset()
    flags_clear: frozenset[FlagName] = frozenset()
    joints_urad: Joints | None = None
    opening_10um: tuple[int, int] | None = None
    begun_is_not: int | None = None
    taken_is_not: int | None = None


class Start(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Where the arm stands at the beginning, and how exactly joints are compared, both in µrad."""

    joints_urad: Joints
    tolerance_urad: int


class Scenario(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Steps in the order of time; `page` is the sentence of docs/c500c.md that they test."""

    name: str
    page: str
    step: list[Step]


class Scenarios(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """What a file of scenarios holds."""

    start: Start
    scenario: list[Scenario]


def load_frames() -> Frames:
    """The frames; msgspec.ValidationError when the file is not as it should be."""
    return msgspec.toml.decode((FOLDER / "frames.toml").read_bytes(), type=Frames)


def load_scenarios() -> list[tuple[Start, Scenario]]:
    """The scenarios of all other files, each with its start."""
    paths = sorted(FOLDER.glob("*.toml"))
    files = [msgspec.toml.decode(path.read_bytes(), type=Scenarios) for path in paths if path.name != "frames.toml"]
    return [(file.start, scenario) for file in files for scenario in file.scenario]
