"""A session at a constant rate: of everything the newest that is not later than the instant."""

import numpy as np
import pytest

from common.clock import NS_PER_MS, NS_PER_S
from farhand.export.resampling import instants, known_from, rows_at, views_at
from farhand.export.session import Signal, ViewPicture, newest_index
from tests.farhand.export.made_session import BEGIN_NS, OPEN_M, MadeSession, at_s, joints


def test_instants_do_not_drift_and_end_before_the_end():
    at = instants(5, 5 + 3 * NS_PER_S, 30)
    assert len(at) == 90
    assert at[0] == 5
    assert at[-1] - 5 == pytest.approx(89 * NS_PER_S / 30, abs=1)
    assert len(instants(5, 5, 30)) == len(instants(5, 4, 30)) == 0
    assert instants(0, NS_PER_S // 30 + 1, 30).tolist() == [0, 33_333_333]


def test_newest_is_never_later_than_the_instant():
    t_ns = np.array([10, 20, 30])
    assert newest_index(t_ns, np.array([9, 10, 19, 20, 99])).tolist() == [-1, 0, 0, 1, 2]
    signal = Signal(t_ns, np.array([[1.0], [2.0], [3.0]]))
    assert signal.at(np.array([9, 29]))[:, 0].tolist() == pytest.approx([np.nan, 2.0], nan_ok=True)
    assert signal.times_at(np.array([9, 29])).tolist() == [0, 20]


def test_signal_that_never_came_is_unknown_throughout():
    nothing = Signal(np.zeros(0, np.int64), np.zeros((0, 2)))
    assert np.isnan(nothing.at(np.array([1, 2]))).all()
    assert nothing.times_at(np.array([1, 2])).tolist() == [0, 0]
    made = MadeSession().signals()
    assert known_from(made) == BEGIN_NS + NS_PER_MS  # what was sent comes last
    assert known_from(made._replace(joints=nothing)) is None


def test_rows_say_what_was_measured_and_sent_and_when():
    made = MadeSession(phase=0.3)
    at = np.array([at_s(2.0), at_s(2.0) + 2 * NS_PER_MS])
    rows = rows_at(made.signals(), at)
    assert rows.q_ns.tolist() == [at_s(2.0)] * 2
    assert rows.sent_ns.tolist() == [at_s(1.997), at_s(2.001)]
    np.testing.assert_allclose(rows.sent_q, joints(rows.sent_ns - NS_PER_MS, 0.3) + 0.01)
    assert (rows.hand_ns - rows.sent_ns).tolist() == [-61 * NS_PER_MS] * 2


def test_gripper_that_is_to_stay_is_sent_what_it_measures():
    rows = rows_at(MadeSession().signals(), np.array([at_s(1.1), at_s(1.5), at_s(1.9)]))
    assert rows.sent_opening[:2].tolist() == [OPEN_M, 0.0]
    assert rows.opening is not None
    assert rows.sent_opening[2] == rows.opening[2]


def test_views_begin_once_each_has_a_picture_and_keep_the_newest():
    given = [ViewPicture("a", 10, b"a1"), ViewPicture("b", 25, b"b1"), ViewPicture("a", 40, b"a2")]
    shown = list(views_at([0, 20, 30, 40, 50], iter(given), ("a", "b")))
    assert [frame.instant_ns for frame in shown] == [30, 40, 50]
    assert [frame.pictures["a"].jpeg for frame in shown] == [b"a1", b"a2", b"a2"]
    assert {frame.pictures["b"].jpeg for frame in shown} == {b"b1"}
    assert list(views_at([0, 20], iter(given), ("a", "c"))) == []
