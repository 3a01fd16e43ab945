"""A real recorder beside real sites: the lease's holder begins it, a kill costs it a second and the arm nothing."""

import os
import signal
import time
from pathlib import Path

import pytest

from common.errors import TransportError
from common.link.channels import PREVIEW, RECORDING
from common.messages.recording import EpisodeOutcome, RecordingNotice, RecordingState
from common.messages.requests import RecordAction
from common.messages.robot import FOLLOWING
from common.recording.reader import RecordingReader
from common.recording.repair import repair
from farhand.authority.engage import request_engage
from farhand.authority.record import request_record
from remote_site.recording.cycle_record import decode_outcome
from tests.integration.sites import CELL, LIGHT_LOCAL, LIGHT_REMOTE, PATIENT, Sites, running_sites
from tests.late_machine import was_late

OPERATOR = "anna"


def ask(sites: Sites, action: RecordAction, operator: str = OPERATOR, **given: object) -> None:
    at = sites.endpoints
    request_record(CELL, at.control, at.listen, operator, action, **given)  # type: ignore[arg-type]


def recording(sites: Sites) -> RecordingState:
    state = sites.state.recording
    assert state is not None
    return state


@pytest.mark.slow
def test_the_holder_records_and_a_killed_recorder_costs_a_second_and_the_arm_nothing(tmp_path: Path) -> None:
    out = tmp_path / "recordings"
    with running_sites() as sites:
        robot = ("driver.name=kinematic", *PATIENT)
        sites.remote(*robot)
        sites.local(f"authority.operator={OPERATOR}")
        sites.wait_for_states()
        sites.wait("the lease", lambda: sites.state.lease is not None)
        with pytest.raises(TransportError, match="no_recorder"):
            ask(sites, RecordAction.START)
        where = (f"record.folder={out}", "record.start=on_request")
        recorder = sites.start("record", *sites.endpoints.remote, *LIGHT_REMOTE, *robot, *where)
        sites.wait("the recorder", lambda: sites.state.recording is not None)
        assert not recording(sites).writing
        with pytest.raises(TransportError, match="not_holder"):
            ask(sites, RecordAction.START, "ben")
        ask(sites, RecordAction.START)
        sites.wait("the mark", lambda: recording(sites).writing)
        sites.wait("readiness", lambda: sites.state.readiness.ready)
        request_engage(CELL, sites.endpoints.control, OPERATOR)
        sites.wait("an episode", lambda: recording(sites).episode_open)
        ask(sites, RecordAction.LABEL, task="wave", outcome=EpisodeOutcome.SUCCESS)
        sites.wait("the label", lambda: recording(sites).outcome is EpisodeOutcome.SUCCESS)
        time.sleep(3.0)
        os.kill(recorder.pid, signal.SIGKILL)
        killed_ns = time.monotonic_ns()
        sites.wait("its end", lambda: sites.state.recording is None)
        assert sites.state.state in FOLLOWING or was_late(sites.state.reason)
    (path,) = out.iterdir()
    assert not repair(path).was_whole
    with RecordingReader(path) as reader:
        cycles = [(m.t_ns, decode_outcome(m.data).number) for m in reader.messages(["/cycle/outcome"])]
        states = sum(1 for _ in reader.messages([f"farhand/{CELL}/state"]))
        pictures = {topic for topic in reader.topics if topic.startswith("/camera/")}
        asked = list(reader.messages([f"farhand/{CELL}/rpc/record/{OPERATOR}"]))
    numbers = [number for _, number in cycles]
    assert numbers == list(range(numbers[0], numbers[0] + len(numbers)))
    assert states > len(cycles) / 10
    assert len(pictures) == 4
    assert len(asked) >= 1
    assert cycles[-1][0] > killed_ns - 4e9  # a second, and what a busy machine takes to flush and to kill


@pytest.mark.slow
def test_the_operators_own_recorder_keeps_hand_states_and_views_once_asked_and_says_so(tmp_path: Path) -> None:
    out, told = tmp_path / "recordings", list[RecordingNotice]()
    with running_sites() as sites:
        sites.remote("driver.name=kinematic", *PATIENT)
        sites.local(f"authority.operator={OPERATOR}")
        sites.wait_for_states()
        notices = sites.link.latest(RECORDING, CELL, operator=OPERATOR)
        who = (f"authority.operator={OPERATOR}", "record.operator_pictures=true", f"record.folder={out}")
        recorder = sites.start("record", *sites.endpoints.local, *LIGHT_LOCAL, *who, "record.start=on_request")

        def newest() -> RecordingState | None:
            told.extend(notice for notice in [notices.take()] if notice is not None)
            return told[-1].state if told else None

        def follows() -> bool:
            state = newest()
            return state is not None and state.episode_open

        sites.wait("the recorder", lambda: newest() is not None)
        sites.wait("the lease", lambda: sites.state.lease is not None)
        ask(sites, RecordAction.START)
        sites.wait("the mark", lambda: (state := newest()) is not None and state.writing)
        sites.wait("readiness", lambda: sites.state.readiness.ready)
        request_engage(CELL, sites.endpoints.control, OPERATOR)
        sites.wait("the notice of an episode", follows)
        views = sites.link.latest(PREVIEW, CELL, "left", operator=OPERATOR)

        def seen() -> bool:
            view = views.take()
            return view is not None and bool(view.data)

        sites.wait("a view of the operator, drawn when the machine has time for it", seen)
        sites.wait("another", seen)
        time.sleep(1.0)
        assert told[-1].state.writing
        assert told[-1].state.operator_pictures
        ask(sites, RecordAction.STOP)
        sites.wait("the end", lambda: (state := newest()) is not None and not state.writing)
        recorder.end()
    (path,) = out.iterdir()
    with RecordingReader(path) as reader:
        kept = reader.topics
    assert kept[f"farhand/{CELL}/hand/{OPERATOR}"] > 10
    assert kept[f"farhand/{CELL}/state"] > 10
    assert kept["/operator/left"] >= 1
    assert kept[f"/hand/{OPERATOR}"] == kept[f"farhand/{CELL}/hand/{OPERATOR}"]
