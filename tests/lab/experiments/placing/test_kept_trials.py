"""Trials that are done are read back as they were; what another version did, or a kill cut off, is run again."""

import pytest

from common.errors import ConfigError
from lab.experiments.placing.judge import Placed
from lab.experiments.placing.kept_trials import FILE, KeptTrials
from lab.experiments.placing.network import Network
from lab.experiments.placing.trial import Conditions, TrialResult
from lab.experiments.placing.trials import run_all

PLAIN = Conditions("silhouette", True, 7)
OVER_NETWORK = Conditions("markers", False, 8, ("exact_hand", "unseen_turn"), Network(delay_ms=40.0), assist=True)


def result(x_mm):
    return TrialResult(Placed(x_mm, -1.0, 0.1, True), 30.5, 0, 1, 2, 0, 3, 21.5, 60.0)


@pytest.fixture
def folder(tmp_path):
    kept = KeptTrials(tmp_path, "1")
    kept.keep(PLAIN, result(0.1))
    kept.keep(OVER_NETWORK, result(0.2))
    return tmp_path


def test_trials_are_read_back_as_they_were(folder):
    assert KeptTrials(folder, "1").results == {PLAIN: result(0.1), OVER_NETWORK: result(0.2)}


def test_what_is_kept_is_not_run_again(folder):
    counted = []
    results = run_all([OVER_NETWORK, PLAIN], lambda: counted.append(1), KeptTrials(folder, "1"))
    assert list(results.items()) == [(OVER_NETWORK, result(0.2)), (PLAIN, result(0.1))]
    assert len(counted) == 2


def test_another_versions_trials_do_not_count(folder):
    assert KeptTrials(folder, "2").results == {}


def test_a_line_that_was_cut_off_is_left_out_and_the_next_one_is_whole(folder):
    path = folder / FILE
    path.write_bytes(path.read_bytes()[:-20])
    kept = KeptTrials(folder, "1")
    assert kept.results == {PLAIN: result(0.1)}
    kept.keep(OVER_NETWORK, result(0.3))
    assert KeptTrials(folder, "1").results == {PLAIN: result(0.1), OVER_NETWORK: result(0.3)}


def test_a_damaged_file_is_refused_with_what_to_do(folder):
    (folder / FILE).write_text("no json\n")
    with pytest.raises(ConfigError, match=r"trials\.jsonl cannot be used .* remove it and run again"):
        KeptTrials(folder, "1")
