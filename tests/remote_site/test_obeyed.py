"""The samples that the robot obeys: none is lost while a slow robot lags behind."""

import msgspec

from common.messages import Obeyed
from remote_site.obeyed import ObeyedSamples


def sample(seq):
    return Obeyed(session=1, seq=seq, capture_ns=seq * 100, command_ns=seq * 100 + 20, motion_ns=None)


def moved(seq, t_ns):
    return msgspec.structs.replace(sample(seq), motion_ns=t_ns)


def test_a_quick_robots_sample_is_told_first_without_its_motion_and_then_with_it():
    samples = ObeyedSamples()
    assert samples.told() is None
    samples.commanded(sample(1), 10)
    samples.reached(9, 125)
    assert samples.told() == sample(1)
    samples.reached(10, 130)
    samples.reached(11, 134)
    assert samples.told() == samples.told() == moved(1, 130)


def test_a_slow_robots_motion_is_told_though_newer_samples_are_obeyed_by_now():
    samples = ObeyedSamples()
    for seq in (1, 2, 3):
        samples.commanded(sample(seq), 10 * seq)
    samples.reached(None, 310)
    assert samples.told() == sample(3)
    samples.reached(25, 400)
    assert samples.told() == moved(2, 400)  # the newest that the motion shows
    assert samples.told() == sample(3)
    samples.reached(30, 450)
    assert samples.told() == samples.told() == moved(3, 450)
