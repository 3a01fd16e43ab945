"""What is altered in the trials of "causes", and what its report makes of them."""

import numpy as np
import pytest

from common.clock import NS_PER_S
from common.geometry import Array
from common.messages.hand import TrackingStatus
from lab.experiments.placing import causes
from lab.experiments.placing.alterations import FINGER_ERRORS, FingerErrors, at_thesis_rate, thesis_local
from lab.experiments.placing.judge import Placed
from lab.experiments.placing.trial import TrialResult, remote_config
from local_site.tracking.tracker import ArmEstimate
from tests.present import present


def errors_of(seed, seconds):
    """Errors of index and thumb (n, 3) in m, over some time at 30 estimates a second."""
    fingers, off = FingerErrors(np.random.default_rng(seed)), dict[str, list[Array]](index=[], thumb=[])
    for k in range(30 * seconds):
        at = ArmEstimate(k * NS_PER_S // 30, TrackingStatus.TRACKED, "", index=np.ones(3), thumb=np.zeros(3))
        moved = fingers.add(at)
        off["index"].append(present(moved.index) - 1.0)
        off["thumb"].append(present(moved.thumb))
    return {name: np.array(values) for name, values in off.items()}


@pytest.mark.parametrize("finger", ["index", "thumb"])
def test_fingers_are_off_by_a_constant_and_a_wander_as_large_as_the_thesis_measured(finger):
    off = errors_of(1, 1000)[finger]
    mean_m, deviation_m = FINGER_ERRORS[finger]
    assert np.linalg.norm(off.mean(axis=0)) == pytest.approx(mean_m, rel=0.1)
    assert np.linalg.norm(off.std(axis=0)) == pytest.approx(deviation_m, rel=0.1)


def test_the_errors_are_those_of_the_seed_and_wander_slowly():
    one, again, other = errors_of(1, 5)["index"], errors_of(1, 5)["index"], errors_of(2, 5)["index"]
    assert one.tolist() == again.tolist()
    assert np.linalg.norm(one.mean(axis=0) - other.mean(axis=0)) > 0.003
    assert np.abs(np.diff(one, axis=0)).mean() < 0.3 * one.std()


def test_a_lost_hand_has_no_fingers_to_be_off():
    lost = ArmEstimate(0, TrackingStatus.LOST, "nothing to see")
    assert FingerErrors(np.random.default_rng(0)).add(lost) is lost


def test_the_thesis_rate_is_the_shipped_one():
    config = at_thesis_rate(remote_config(np.random.default_rng(0)))
    assert config.safety.t_soft_ms == 400
    assert (thesis_local().smoothing.method, thesis_local().smoothing.mean_frames) == ("mean", 9)
    assert config.video.calibrated


def left(conditions):
    """A block that stands askew by as much as parts are altered, and is not placed where they are two."""
    count = len(conditions.altered)
    return TrialResult(Placed(10.0 * count, -1.0, 30.0 * count, count < 2), 30.0, 0, 1, 3, 0, 0, 20.0)


@pytest.fixture
def report():
    return causes.causes_report({c: left(c) for c in causes.causes_conditions(quick=True)})


def test_the_errors_are_of_all_trials_by_what_was_altered(report):
    for of in report.figures.values():
        assert list(of) == list(causes.CAUSES)
        assert of["as_it_is"]["angle_deg"]["median"] == 0.0
        both = of["thesis_fingers_unseen_turn"]
        assert (both["placed"], both["x_mm"]["median"], both["angle_deg"]["median"]) == (0, 20.0, 60.0)
    assert report.plots["causes"].startswith(b"\x89PNG")
    assert len(report.data) == 2 * len(causes.CAUSES)


def test_a_run_cut_short_has_all_causes_of_its_first_seeds():
    conditions = causes.causes_conditions(quick=False)
    first = conditions[: 2 * len(causes.CAUSES)]
    assert {each.seed for each in first} == {causes.SEEDS[0]}
    assert len(set(conditions)) == len(conditions) == 2 * len(causes.CAUSES) * len(causes.SEEDS)
