"""What control and video share for fine adjustment: joints between readings, and sightings as they were written."""

import numpy as np
import pytest

from remote_site.assist.config import AssistConfig
from remote_site.reasons import Code, reason
from remote_site.runtime.assist_memory import AssistMemory
from tests.present import present
from tests.remote_site.assist.sightings import CONFIG, MARKER, refused, seen

MS = 1_000_000


def memory(config: AssistConfig = CONFIG) -> AssistMemory:
    return AssistMemory(config, 2)


def test_joints_are_known_between_readings_and_shortly_after_the_newest():
    shared = memory()
    for k in range(1, 500):
        shared.show_joints(k * 4 * MS, np.array([k, -2.0 * k]))
    assert shared.joints_at(1991 * MS) == pytest.approx([497.75, -995.5])
    assert shared.joints_at(499 * 4 * MS + 10 * MS) == pytest.approx([499, -998])


def test_joints_of_long_ago_or_of_later_are_not_known():
    shared = memory()
    assert shared.joints_at(5 * MS) is None
    for k in range(1, 500):
        shared.show_joints(k * 4 * MS, np.array([k, -2.0 * k]))
    assert shared.joints_at(400 * MS) is None
    assert shared.joints_at(499 * 4 * MS + 30 * MS) is None


def test_sightings_are_taken_once_as_they_were_written():
    shared = memory()
    assert shared.take_markers() == ()
    pose = np.arange(16.0).reshape(4, 4)
    shared.show_markers([seen(7 * MS, pose)])
    (taken,) = shared.take_markers()
    assert np.array_equal(present(taken.base_T_marker), pose)
    assert taken._replace(base_T_marker=None) == seen(7 * MS, pose)._replace(base_T_marker=None)
    assert shared.take_markers() == ()


def test_a_refusal_comes_with_its_code_and_sentence():
    shared = memory()
    why = refused(9 * MS, reason(Code.MARKER_UNSEEN, marker=MARKER))
    shared.show_markers([why])
    assert shared.take_markers() == (why,)


def test_the_names_of_more_views_than_there_is_room_for_are_cut():
    shared = memory()
    shared.show_markers([seen(7 * MS, np.eye(4))._replace(views=tuple("a" + "ü" * 62 + str(k) for k in range(9)))])
    (taken,) = shared.take_markers()
    assert taken.views[0] == "a" + "ü" * 62 + "0"
