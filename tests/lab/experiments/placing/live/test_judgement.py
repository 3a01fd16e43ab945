"""The judge in the cell's process: it says nothing before the cell ends, and then what a stepped trial's judge says."""

import msgspec
import pytest

from lab.experiments.placing.judge import Judge
from lab.experiments.placing.live.judgement import TrialJudgement, judged
from remote_site.config import RemoteConfig
from remote_site.simulation.memory import CellMemory
from remote_site.simulation.process import SimulatedCell

CONFIG = RemoteConfig()
STEPS = 20


@pytest.fixture
def cell():
    return SimulatedCell(CONFIG.simulation, CONFIG.robot, CellMemory.create(6))


def step(cell, stepped):
    for k in range(STEPS):
        t_ns = (k + 1) * 2_000_000
        cell.step(t_ns, t_ns)
        stepped()


def test_nothing_is_told_before_the_cell_ends(cell, tmp_path):
    out = tmp_path / "end"
    with judged(CONFIG, out, cell) as stepped:
        step(cell, stepped)
        assert list(tmp_path.iterdir()) == []
    told = msgspec.json.decode(out.read_bytes(), type=TrialJudgement)
    assert told.end == Judge(CONFIG, cell).placed()
    assert (told.drops, told.collisions, told.grip_force_n) == (0, 0, 0.0)
    assert not told.end.placed


def test_a_cell_that_fails_is_not_judged(cell, tmp_path):
    with pytest.raises(RuntimeError), judged(CONFIG, tmp_path / "end", cell):
        raise RuntimeError("diverged")
    assert list(tmp_path.iterdir()) == []


def test_it_watches_once_in_each_control_period_as_in_lockstep(cell, tmp_path, monkeypatch):
    watched = []
    monkeypatch.setattr(Judge, "watch", lambda _judge: watched.append(1))
    with judged(CONFIG, tmp_path / "end", cell) as stepped:
        step(cell, stepped)
    assert len(watched) == STEPS * cell.dt * CONFIG.control.rate_hz
