"""The room is learned from pictures that are older than the first sight of an arm."""

from local_site.tracking.learned.room_pictures import COMES_IN, WANTED, RoomPictures
from tests.local_site.tracking.landmarks.scripted_hands import instant
from tests.present import present


def test_the_newest_pictures_are_held_back():
    room = RoomPictures()
    given = [room.take(instant(k)) for k in range(COMES_IN + 5)]
    assert given[:COMES_IN] == [None] * COMES_IN
    assert [present(views).t_ns for views in given[COMES_IN:]] == [instant(k).t_ns for k in range(5)]


def test_no_picture_is_given_in_which_an_arm_may_have_come_in():
    room, given = RoomPictures(), []
    entered = 20
    for k in range(entered):
        given.append(room.take(instant(k)))
    room.forget()
    given += [room.take(instant(k)) for k in range(100, 100 + COMES_IN)]
    assert max(views.t_ns for views in given if views is not None) <= instant(entered - COMES_IN).t_ns


def test_it_is_content_after_a_while():
    room = RoomPictures()
    given = [room.take(instant(k)) for k in range(COMES_IN + 3 * WANTED) if room.is_learning]
    assert len([views for views in given if views is not None]) == WANTED
    assert not room.is_learning
    assert room.take(instant(1000)) is None


def test_what_was_learned_before_an_arm_came_in_counts_on():
    room = RoomPictures()
    for start in range(0, 1000, 100):
        for k in range(COMES_IN + WANTED // 2):
            room.take(instant(start + k))
        room.forget()
        if start == 0:
            assert room.is_learning
    assert not room.is_learning
