"""The page's types of messages name only what the console sends, and only requests that it knows."""

import dataclasses
import json
import re
from pathlib import Path
from typing import Any, get_args

import msgspec
import pytest

from common.clock import ClockOffset
from common.messages.hand import OperatorSettings
from common.messages.recording import RecordingState
from common.messages.requests import CameraDescription, Description, JointDescription, ViewCalibration
from common.messages.robot import (
    AssistState,
    AssistTarget,
    GripperState,
    HandLink,
    Pose,
    RobotState,
    SessionState,
    VideoLink,
)
from common.messages.shapes import BoxDescription
from lab.measure.page import scene
from local_site.console.model.frames import LENGTH, view_frame
from local_site.console.model.history import History
from local_site.console.model.latency import Latencies, Trace
from local_site.console.model.page_messages import AnyPageMessage, Painted
from local_site.console.model.seat import Seat
from local_site.console.model.sent_target import tools_json
from local_site.console.model.situation import NewestMessages, situation_json

TYPES = (Path(__file__).parents[4] / "local_site/console/model/messages.d.ts").read_text()
INTERFACES = {
    name: (base, set(re.findall(r"^  (\w+)\??:", body, re.M)))
    for name, base, body in re.findall(r"^export interface (\w+)(?: extends (\w+))? \{\n(.*?)^\}", TYPES, re.S | re.M)
}
STRUCTS: dict[str, type[msgspec.Struct]] = {
    "Pose": Pose,
    "Joint": JointDescription,
    "Calibration": ViewCalibration,
    "Camera": CameraDescription,
    "Box": BoxDescription,
    "Cell": Description,
    "HandLink": HandLink,
    "VideoLink": VideoLink,
    "Assist": AssistState,
    "AssistTarget": AssistTarget,
    "Gripper": GripperState,
    "Recording": RecordingState,
    "Settings": OperatorSettings,
    "Painted": Painted,
}


def read(interface: str) -> set[str]:
    """The names of an interface's fields, with those of the one that it extends."""
    base, own = INTERFACES[interface]
    return own | (read(base) if base else set())


def state() -> RobotState:
    return scene.state(SessionState.ENGAGED, "ok", "the arm follows the hand")


def situation() -> dict[str, Any]:
    """The situation of an arm that follows a hand."""
    robot, history = state(), History()
    history.add_state(robot, robot.t_ns)
    newest = NewestMessages(robot, robot.t_ns, scene.hand(), robot.t_ns)
    seat, latencies = Seat(open_=True), Latencies()
    made: dict[str, Any] = json.loads(situation_json(robot.t_ns, newest, None, None, seat, None, latencies, history))
    return made


@pytest.mark.parametrize("interface", STRUCTS)
def test_a_struct_has_what_the_page_reads(interface: str) -> None:
    assert read(interface) <= {field.name for field in msgspec.structs.fields(STRUCTS[interface])}


def test_the_situation_has_what_the_page_reads() -> None:
    told = situation()
    examples = {
        "Situation": told,
        "Robot": told["robot"],
        "Lease": told["robot"]["lease"],
        "Hand": told["hand"],
        "Seat": told["seat"],
        "Visitor": told["stopper"],
        "Clock": told["clock"],
        "Figures": told["latency"]["command"],
        "Event": told["events"][0],
    }
    for interface, example in examples.items():
        assert read(interface) <= set(example), interface
    assert read("Trace") == {field.name for field in dataclasses.fields(Trace)}
    (intervals,) = re.findall(r"^export type Interval = (.*);$", TYPES, re.M)
    assert set(re.findall(r'"(\w+)"', intervals)) == set(told["latency"])


def test_tools_and_headers_of_pictures_have_what_the_page_reads() -> None:
    tools = json.loads(tools_json(state(), None, None, None, ClockOffset(0, 0)))
    assert read("Tools") == set(tools)
    assert read("TimedPose") == set(tools["measured"])
    payload = view_frame("camera/side", scene.picture("side", 1, b"jpeg"), None).payload
    (length,) = LENGTH.unpack_from(payload)
    assert read("PictureHeader") <= set(json.loads(payload[LENGTH.size : LENGTH.size + length]))


def test_the_page_sends_the_messages_that_the_console_knows() -> None:
    sent = re.findall(r"\{ type: ([^;}]*)", TYPES)
    assert {name for words in sent for name in re.findall(r'"(\w+)"', words)} == {
        message.__struct_config__.tag for message in get_args(AnyPageMessage)
    }
