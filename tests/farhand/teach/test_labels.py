"""Labels of a picture: every point is named, and none covers another."""

from itertools import combinations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from farhand.teach.labels import MOST_LABELS, LabelBox, in_words, overlap, placed, taken_together

ROOM = LabelBox(0.0, 0.0, 400.0, 400.0)
POINT = st.tuples(st.floats(0, 400), st.floats(0, 400))


@settings(max_examples=20, deadline=None)
@given(st.lists(POINT, min_size=1, max_size=60), st.floats(1.0, 30.0))
def test_each_point_is_in_one_group_near_its_first(points, within):
    groups = taken_together(np.array(points), within)
    assert sorted(k for group in groups for k in group) == list(range(len(points)))
    assert len(groups) <= MOST_LABELS
    assert all(group == sorted(group) for group in groups)


def test_points_far_apart_have_labels_of_their_own_and_those_together_one():
    points = np.array([[0.0, 0.0], [100.0, 0.0], [3.0, 2.0], [100.0, 100.0]])
    assert taken_together(points, 10.0) == [[0, 2], [1], [3]]


def test_numbers_are_written_as_a_person_does():
    assert in_words([4]) == "4"
    assert in_words([2, 3, 4, 9, 11, 12]) == "2–4, 9, 11–12"


@settings(max_examples=10, deadline=None)
@given(st.lists(POINT, min_size=2, max_size=12))
def test_no_label_covers_another_and_all_are_in_the_picture(anchors):
    anchors = np.array(anchors)
    labels = placed(anchors, np.tile([40.0, 12.0], (len(anchors), 1)), anchors, ROOM)
    assert all(overlap(a, b) < 1e-6 for a, b in combinations(labels, 2))
    assert all(overlap(label, ROOM) > 0.99 * 40.0 * 12.0 for label in labels)


def test_a_label_gives_way_to_points_and_stays_near():
    anchor = np.array([200.0, 200.0])
    right = np.column_stack([np.linspace(200.0, 400.0, 50), np.linspace(190.0, 230.0, 50)])
    (label,) = placed(anchor[None], np.array([[40.0, 12.0]]), np.vstack([anchor, right]), ROOM)
    assert label.right <= 200.0 or label.bottom > 200.0 or label.top < 200.0
    covered = (right > label[:2]) & (right < label[2:])
    assert not covered.all(axis=1).any()
    assert np.linalg.norm(np.clip(anchor, label[:2], label[2:]) - anchor) < 20.0
