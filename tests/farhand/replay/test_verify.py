"""A recording's inputs through today's pipeline: the same commands, or the first cycle that differs."""

from dataclasses import replace
from importlib import metadata
from pathlib import Path

import msgspec
import pytest
from typer.testing import CliRunner

import farhand.replay.recorded_cycles as recorded_module
from common.errors import RecordingError
from common.messages.base import PROTOCOL_VERSION
from common.messages.requests import EngagementAction
from common.messages.robot import SessionState
from common.recording.folder import parts_from
from farhand.cli import app
from farhand.replay.recorded_cycles import recorded_cycles, recorded_pipeline
from farhand.replay.verify import verify
from remote_site.kinematics.limits import load_arm
from remote_site.teleop.pipeline import TeleopPipeline
from tests.remote_site.driven_loop import CONFIG
from tests.remote_site.recording.recorded_site import RecordedSite

SECONDS, SPEED_M_S = 4.0, 0.05
CHANGED = 600


def engaged(site: RecordedSite) -> None:
    """Activate the robot, and engage."""
    site.loop.link.activate(CONFIG.robot.start)
    site.run(0.4)
    site.loop.ask(EngagementAction.ENGAGE)
    site.note()
    assert site.loop.state is SessionState.ENGAGED


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A site that was recorded from its start, while a hand moved its arm."""
    site = RecordedSite(tmp_path_factory.mktemp("site"))
    engaged(site)
    site.run(SECONDS, SPEED_M_S)
    site.recorder.step(site.clock.now_ns())
    site.recorder.end(site.clock.now_ns())
    return site.files[0]


@pytest.fixture(scope="module")
def cycles(recording):
    return list(recorded_cycles(recording))


@pytest.fixture
def pipeline(recording, tmp_path):
    return recorded_pipeline(recording, tmp_path)


@pytest.mark.slow
def test_a_recording_gives_the_same_commands_bit_for_bit(recording, cycles):
    result = CliRunner().invoke(app, ["replay", "--verify", str(recording)])
    assert result.exit_code == 0
    assert f"all {len(cycles)} control cycles give the same commands, bit for bit" in " ".join(result.output.split())


def test_the_recorded_arm_has_really_moved(cycles):
    moved = abs(cycles[-1].outcome.motion.q - cycles[0].outcome.motion.q).max()
    assert moved > 0.05


def test_the_first_cycle_that_differs_is_named_with_by_how_much(cycles, pipeline):
    outcome = cycles[CHANGED].outcome
    off = replace(outcome.motion, q=outcome.motion.q + 1e-6)
    altered = [
        *cycles[:CHANGED],
        cycles[CHANGED]._replace(outcome=outcome._replace(motion=off)),
        *cycles[CHANGED + 1 :],
    ]
    verdict = verify(altered, pipeline)
    assert verdict.difference is not None
    assert verdict.difference.cycle == outcome.number == CHANGED + 1
    assert verdict.difference.at_s == pytest.approx(CHANGED * 0.004)
    assert "1.0e-06 rad" in verdict.in_words()


def test_another_processors_rounding_is_no_difference(cycles, pipeline):
    rounded = [
        c._replace(outcome=c.outcome._replace(motion=replace(c.outcome.motion, q=c.outcome.motion.q + 1e-12)))
        for c in cycles
    ]
    verdict = verify(rounded, pipeline)
    assert verdict.difference is None
    assert "to 1.0e-12 rad" in verdict.in_words()


def test_a_decision_that_differs_is_named(cycles, pipeline):
    altered = [c._replace(outcome=c.outcome._replace(held=True)) for c in cycles]
    verdict = verify(altered, pipeline)
    assert verdict.difference is not None
    assert verdict.in_words().endswith("held was True, is False")


def test_what_another_release_recorded_and_decided_otherwise_is_said_to_be_of_another_release(
    cycles, recording, monkeypatch
):
    altered = [c._replace(outcome=c.outcome._replace(held=True)) for c in cycles]
    monkeypatch.setattr(recorded_module, "_cycles_in", lambda _: iter(altered))
    said = []
    for today in (metadata.version("farhand"), "99.0.0"):
        monkeypatch.setattr(recorded_module, "version", lambda _, today=today: today)
        result = CliRunner().invoke(app, ["replay", "--verify", str(recording)])
        assert result.exit_code == 1
        said.append(" ".join(result.output.split()))
    assert "recorded by" not in said[0]
    assert f"recorded by Farhand {metadata.version('farhand')} with wire protocol {PROTOCOL_VERSION}" in said[1]
    assert "this is Farhand 99.0.0" in said[1]
    assert "verify it with the release that recorded it" in said[1]


def test_a_pipeline_that_is_configured_otherwise_is_noticed(cycles):
    control = msgspec.structs.replace(CONFIG.control, predict_ms=0.0)
    other = TeleopPipeline(msgspec.structs.replace(CONFIG, control=control), *load_arm(CONFIG.robot))
    assert verify(cycles, other).difference is not None


def test_a_recording_that_begins_in_the_middle_is_refused_with_the_cure(cycles, recording, monkeypatch):
    monkeypatch.setattr(recorded_module, "_cycles_in", lambda _: iter(cycles[3:]))
    with pytest.raises(RecordingError, match=r"begins with control cycle 4 .*at_once"):
        list(recorded_cycles(recording))


def test_cycles_that_are_missing_are_counted(cycles, recording, monkeypatch):
    monkeypatch.setattr(recorded_module, "_cycles_in", lambda _: iter([*cycles[:10], *cycles[15:]]))
    with pytest.raises(RecordingError, match="5 control cycles are missing before cycle 16"):
        list(recorded_cycles(recording))


def test_the_parts_that_follow_a_file_belong_to_it(tmp_path):
    names = [f"20260102T030405Z_{cell}_{part:03d}.mcap" for cell in ("a", "b") for part in (1, 2, 3)]
    for name in names:
        (tmp_path / name).touch()
    assert [part.name for part in parts_from(tmp_path / names[1])] == names[1:3]
    assert parts_from(tmp_path / "own.mcap") == [tmp_path / "own.mcap"]


def test_a_file_that_cannot_be_verified_leaves_no_empty_line(tmp_path, capfd):
    bad = tmp_path / "bad.mcap"
    bad.write_text("no recording")
    refused = CliRunner().invoke(app, ["replay", "--verify", str(bad)])
    assert isinstance(refused.exception, RecordingError)
    assert (refused.stderr, capfd.readouterr().err) == ("", "")


def test_a_file_that_is_no_recording_is_an_error(tmp_path):
    file = tmp_path / "notes.mcap"
    file.write_text("no recording")
    result = CliRunner().invoke(app, ["replay", "--verify", str(file)])
    assert isinstance(result.exception, RecordingError)
