"""The control cycles of a recording, and the pipeline that they went through."""

from collections.abc import Iterator
from importlib.metadata import version
from pathlib import Path
from typing import NamedTuple
from xml.etree import ElementTree

import msgspec

from common.errors import MessageError, RecordingError
from common.messages.base import PROTOCOL_VERSION
from common.recording.folder import parts_from
from common.recording.reader import RecordingReader, as_recorded
from common.text import cut
from remote_site.config import RemoteConfig
from remote_site.kinematics.limits import load_arm
from remote_site.kinematics.meshes import place_meshes
from remote_site.recording.cycle_record import CycleOutcome, decode_input, decode_outcome
from remote_site.recording.kept_config import decode_config
from remote_site.recording.topics import CYCLE_INPUT, CYCLE_OUTCOME
from remote_site.recording.transcript import CELL_TABLE, CONFIG_FILE, URDF_FILE
from remote_site.teleop.cycle import CycleInput
from remote_site.teleop.pipeline import TeleopPipeline

SHOWN_WORDS = 40  # of a table that a stranger may have written


class RecordedCycle(NamedTuple):
    """The inputs of a control cycle, and its outcome."""

    given: CycleInput
    outcome: CycleOutcome


def recorded_pipeline(path: Path, folder: Path) -> TeleopPipeline:
    """Today's pipeline with the configuration and the arm of a recording, whose URDF is written into `folder`.

    RecordingError for a file that is no recording of a cell, or one of another release.
    """
    with RecordingReader(path) as recording:
        config = recorded_config(recording, folder)
    return TeleopPipeline(config, *load_arm(config.robot))


def recorded_config(recording: RecordingReader, folder: Path) -> RemoteConfig:
    """The configuration of a recorded site with the recorded arm, whose URDF is written into `folder`.

    RecordingError for a file that is no recording of a cell, or one of another release.
    """
    try:
        config, urdf = decode_config(recording.document(CONFIG_FILE)), recording.document(URDF_FILE)
    except KeyError as error:
        missing = error.args[0]
        raise RecordingError(f"{recording.path} is no recording of a remote site: it has no {missing}") from error
    with as_recorded(recording.path):
        return with_urdf(config, urdf, folder)


def with_urdf(config: RemoteConfig, urdf: bytes, folder: Path) -> RemoteConfig:
    """The configuration with the recorded URDF, written into `folder` unless the one that it names is the same.

    Its meshes stay those of the folder where it was recorded.
    """
    named = config.robot.urdf
    if named.is_file() and named.stat().st_size == len(urdf) and named.read_bytes() == urdf:
        return config
    written = folder / URDF_FILE
    robot = ElementTree.fromstring(urdf)  # noqa: S314  # as the recorded site read it
    place_meshes(config.robot.urdf.parent, robot.iter("mesh"))
    written.write_bytes(ElementTree.tostring(robot))
    return msgspec.structs.replace(config, robot=msgspec.structs.replace(config.robot, model=str(written)))


def other_release(path: Path) -> str:
    """Which release recorded this file, and which this is, as a sentence's beginning; empty where both are one."""
    with RecordingReader(path) as recording, as_recorded(path):
        table = recording.table(CELL_TABLE)
        recorder = _release(table["software"], table["protocol"])
    today = _release(version("farhand"), str(PROTOCOL_VERSION))
    return "" if recorder == today else f"recorded by {recorder}, and this is {today}"


def _release(software: str, protocol: str) -> str:
    return f"Farhand {cut(software, SHOWN_WORDS)} with wire protocol {cut(protocol, SHOWN_WORDS)}"


def cycle_count(path: Path) -> int:
    """Count the cycles that a recording has from this file on."""
    count = 0
    for part in parts_from(path):
        with RecordingReader(part) as recording:
            count += recording.topics.get(CYCLE_OUTCOME.name, 0)
    return count


def recorded_cycles(path: Path) -> Iterator[RecordedCycle]:
    """The cycles of a recording from this file on, in order, the parts that follow it included.

    RecordingError where they do not begin with the site's first one, one is missing between them, or they are of
    another release: what a cycle makes of its input depends on all cycles before it.
    """
    number = 0
    for part in parts_from(path):
        for cycle in _cycles_in(part):
            _check_follows(part, number, cycle.outcome.number)
            number = cycle.outcome.number
            yield cycle


def _cycles_in(path: Path) -> Iterator[RecordedCycle]:
    given = None
    with RecordingReader(path) as recording:
        for message in recording.messages([CYCLE_INPUT.name, CYCLE_OUTCOME.name]):
            try:
                if message.topic == CYCLE_INPUT.name:
                    given = decode_input(message.data)
                elif given is not None:
                    yield RecordedCycle(given, decode_outcome(message.data))
            except MessageError as error:
                raise RecordingError(f"{path}: {error}; replay it with the release that recorded it") from error


def _check_follows(path: Path, before: int, number: int) -> None:
    if before == 0 and number != 1:
        raise RecordingError(
            f"{path} begins with control cycle {number} of its site: only a recording from the site's start can be "
            'verified. Give its first part, or record with record.start = "at_once" and the recorder started first'
        )
    if before and number <= before:
        raise RecordingError(f"{path} is of another start of its site: verify it by itself")
    if before and number != before + 1:
        raise RecordingError(f"{path}: {number - before - 1} control cycles are missing before cycle {number}")
