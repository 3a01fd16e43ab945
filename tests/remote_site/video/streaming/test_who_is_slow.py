"""Who is slow is told apart, link, page and processor, and all comes again within five seconds of the cause's end."""

import numpy as np
import pytest

from common.messages.robot import VideoTrouble
from lab.measure.video.link import StreamRun
from remote_site.video.streaming.busy_hosts import OPERATOR_THREADS
from tests.remote_site.video.streaming.test_adaptation import CONFIG, FULL, pictures, settings

BUSY_MS = 250.0  # within which a processor that is full lets a process run
STEP_S = 0.1
LATELY_STEPS = 5
FREE_MBIT_S = 100.0


class BusyRun(StreamRun):
    """Where a host is busy, it lets pictures wait for a new random time at each step, and tells the longest of late."""

    def __init__(self, mbit_s, *, operator=False, cell=False, seed=1):
        super().__init__(CONFIG, pictures(), mbit_s)
        self.operator, self.cell = operator, cell
        self.chance = np.random.default_rng(seed)
        self.waits = [0.0] * LATELY_STEPS

    def busy(self, seconds):
        """Let time pass; the settings after each step."""
        seen = []
        for _ in range(round(seconds / STEP_S)):
            self.waits = [*self.waits[1:], self.chance.uniform(0.0, BUSY_MS)]
            wait, longest = self.waits[-1], max(self.waits)
            told = longest / OPERATOR_THREADS
            self.viewer.late_ms, self.viewer.waited_ms = (wait, told) if self.operator else (0.0, 0.0)
            self.leaves_ms, self.waited_ms = (wait, longest) if self.cell else (0.0, 0.0)
            self.run(STEP_S)
            seen += settings(self)
        return seen

    def calm(self, seconds):
        """Let time pass without anything that is busy."""
        self.operator = self.cell = False
        return self.busy(seconds)

    @property
    def said(self):
        return self.adaptation.trouble(self.now_ns)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 2, 3])
@pytest.mark.parametrize("hosts", [{"operator": True}, {"cell": True}, {"operator": True, "cell": True}])
def test_what_waits_for_a_processor_is_not_the_links_fault_however_long_it_lasts(hosts, seed):
    run = BusyRun(FREE_MBIT_S, **hosts, seed=seed)
    run.busy(5.0)
    assert all((setting.quality, setting.scale) == (FULL.quality, FULL.scale) for setting in run.busy(60.0))
    assert run.said.code is VideoTrouble.BUSY_HOST
    run.calm(5.0)
    assert settings(run) == [FULL] * 4
    assert run.said is None


def test_the_busy_host_is_named_with_its_cure():
    operator, cell = BusyRun(FREE_MBIT_S, operator=True), BusyRun(FREE_MBIT_S, cell=True)
    for run in (operator, cell):
        run.busy(10.0)
    assert "fewer programs on the operator's host" in operator.said.reason
    assert "fewer programs on the cell's host" in cell.said.reason
    assert not any("link" in run.said.reason for run in (operator, cell))


def test_a_moments_wait_needs_no_cure():
    run = BusyRun(FREE_MBIT_S)
    run.busy(5.0)
    run.operator = True
    run.busy(0.5)
    assert run.said is None


@pytest.mark.parametrize("paints_fps", [3.0, 5.0, 8.0, 15.0, 22.0])
def test_a_page_that_was_too_slow_gets_all_again_within_five_seconds(paints_fps):
    run = BusyRun(FREE_MBIT_S)
    run.viewer.paints_fps = paints_fps
    said = []
    for _ in range(40):
        run.busy(0.5)
        assert all((setting.quality, setting.scale) == (FULL.quality, FULL.scale) for setting in settings(run))
        said.append(run.said)
    codes = {trouble.code for trouble in said if trouble is not None}
    assert codes == {VideoTrouble.SLOW_PAGE} or (paints_fps > 20.0 and not codes), "so few more need no word"
    run.viewer.paints_fps = 1000.0
    run.calm(5.0)
    assert settings(run) == [FULL] * 4
    assert run.said is None


@pytest.mark.slow
@pytest.mark.parametrize("mbit_s", [2.0, 5.0, 20.0])
@pytest.mark.parametrize("narrow_s", [10.0, 11.3, 12.7, 30.0])
def test_a_link_that_was_narrow_carries_all_again_within_five_seconds(mbit_s, narrow_s):
    run = BusyRun(FREE_MBIT_S)
    run.busy(5.0)
    run.link.mbit_s = mbit_s
    run.busy(narrow_s)
    assert run.said.code is VideoTrouble.NARROW
    run.link.mbit_s = 1000.0
    run.calm(5.0)
    assert settings(run) == [FULL] * 4


@pytest.mark.slow
@pytest.mark.parametrize("mbit_s", [5.0, 20.0])
def test_a_narrow_link_is_found_behind_a_busy_host_too(mbit_s):
    run = BusyRun(FREE_MBIT_S, operator=True)
    run.busy(10.0)
    run.link.mbit_s = mbit_s
    run.busy(5.0)
    arrived = len(run.viewer.painted)
    run.busy(20.0)
    assert run.said.code is VideoTrouble.NARROW
    ages_ms = sorted(one.age_ms for one in run.viewer.painted[arrived:])
    assert ages_ms[len(ages_ms) // 2] < 100.0 + BUSY_MS
    assert ages_ms[round(0.95 * len(ages_ms))] < 300.0 + BUSY_MS


def test_a_link_that_becomes_free_is_found_though_the_host_stays_busy():
    run = BusyRun(FREE_MBIT_S, operator=True)
    run.link.mbit_s = 5.0
    run.busy(15.0)
    assert run.said.code is VideoTrouble.NARROW
    run.link.mbit_s = 1000.0
    run.busy(5.0)
    assert run.said.code is VideoTrouble.BUSY_HOST
    assert settings(run) == [FULL] * 4


def test_a_wait_that_nobody_can_have_hides_no_narrow_link():
    run = BusyRun(FREE_MBIT_S)
    run.viewer.waited_ms = 1e12
    run.link.mbit_s = 5.0
    run.run(10.0)
    assert run.said.code is VideoTrouble.NARROW
