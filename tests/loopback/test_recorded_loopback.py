"""A whole run is recorded from its first control cycle: its figures and its commands come again from the file."""

import stat
from pathlib import Path

import pytest

from common.process.service import StopFlag
from common.recording.reader import RecordingReader
from farhand.loopback.measured_run import Loopback
from farhand.loopback.plan import LoopbackOptions
from remote_site.kinematics.limits import load_arm
from remote_site.recording.cycle_record import decode_input, decode_outcome
from remote_site.recording.kept_config import decode_config
from remote_site.teleop.pipeline import TeleopPipeline

SECONDS = 5.0
SMALL = ("video.width=160", "video.height=120", "video.fps=10")


@pytest.mark.long
def test_figures_and_commands_come_again_from_the_recording(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    options = LoopbackOptions(seconds=SECONDS, headless=True, record=path, driver="kinematic", settings=SMALL)
    figures = Loopback(options, StopFlag()).run()
    assert figures["engagements"] >= 1
    assert figures["recording"]["missing"] == 0
    assert figures["recording"]["differing"] == []
    assert stat.S_IMODE(path.stat().st_mode) == 0o600
    with RecordingReader(path) as reader:
        config = decode_config(reader.document("remote.json"))
        inputs = [decode_input(kept.data) for kept in reader.messages(["/cycle/input"])]
        outcomes = [decode_outcome(kept.data) for kept in reader.messages(["/cycle/outcome"])]
    assert [outcome.number for outcome in outcomes] == list(range(1, len(inputs) + 1))
    pipeline = TeleopPipeline(config, *load_arm(config.robot))
    for given, outcome in zip(inputs, outcomes, strict=True):
        command = pipeline.cycle(given)
        assert command.motion.q.tobytes() == outcome.motion.q.tobytes()
        assert (command.snapshot.state, command.snapshot.reason) == (outcome.state, outcome.reason)
