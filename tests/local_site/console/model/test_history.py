"""The page's list of events: the trouble of a link is noted when it begins and ends, not with each of its figures."""

from msgspec.structs import replace

from common.clock import NS_PER_S
from common.messages.robot import SessionState, VideoTrouble
from local_site.console.model.history import History
from tests.common.messages.golden_examples import STATE
from tests.present import present


def test_a_links_trouble_is_noted_once_though_its_figures_change() -> None:
    history, hand = History(), STATE.hand_link
    assert hand is not None
    for second in range(10):
        trouble = replace(hand, reason=f"hand samples are {second} ms too old")
        history.add_state(replace(STATE, hand_link=trouble, video_link=None), second * NS_PER_S)
    history.add_state(replace(STATE, hand_link=replace(hand, code="", reason=""), video_link=None), 10 * NS_PER_S)
    noted = [event.text for event in history.events if event.kind == "link"]
    assert noted == ["the hand's link is good again", "hand samples are 0 ms too old"]


def test_a_link_too_narrow_for_the_pictures_is_noted() -> None:
    history = History()
    history.add_state(replace(STATE, hand_link=None), 0)
    assert [event.text for event in history.events if event.kind == "link"] == [present(STATE.video_link).reason]


def test_a_full_processor_after_a_narrow_link_is_another_event() -> None:
    history, narrow = History(), present(STATE.video_link)
    busy = replace(narrow, code=VideoTrouble.BUSY_HOST, reason="the processor of the operator's host is full")
    for second, trouble in ((0, narrow), (10, busy), (20, None)):
        history.add_state(replace(STATE, hand_link=None, video_link=trouble), second * NS_PER_S)
    noted = [event.text for event in history.events if event.kind == "link"]
    assert noted == ["the pictures' way is good again", busy.reason, narrow.reason]


def test_another_age_limit_is_noted_with_the_speed_it_leaves() -> None:
    history, quiet = History(), replace(STATE, hand_link=None, video_link=None)
    for limit_ms in (100.0, 100.0, 200.0, 200.0, 100.0):
        history.add_state(replace(quiet, age_limit_ms=limit_ms, speed_scale=100.0 / limit_ms), NS_PER_S)
    assert [event.text for event in history.events if event.kind == "link"] == [
        "hand samples up to 100 ms old are obeyed, at 100% of the speed",
        "hand samples up to 200 ms old are obeyed, at 50% of the speed",
    ]


def test_a_reference_that_moved_is_noted_once_with_how_far() -> None:
    history, quiet = History(), replace(STATE, hand_link=None, video_link=None)
    engagement = quiet.engagement
    assert engagement is not None
    for capture_ns, shift_mm in ((1, 0.0), (2, 34.4), (2, 34.4), (3, 0.2)):
        moved = replace(engagement, hand_capture_ns=capture_ns, shift_mm=shift_mm, shift_deg=0.0)
        history.add_state(replace(quiet, engagement=moved), NS_PER_S)
    assert [event.text for event in history.events if event.kind == "link"] == [
        "the reference has moved by 34 mm and 0 deg: the hand's way during the hold is lost"
    ]


def test_each_who_stops_the_arm_is_an_event_also_behind_another_and_in_a_fault() -> None:
    history, quiet = History(), replace(STATE, hand_link=None, video_link=None)
    stopped = replace(quiet, state=SessionState.DISENGAGED, code="stopped")
    failed = replace(quiet, state=SessionState.FAULT, code="fault", reason="stopped by ben; brakes on")
    told = [
        replace(stopped, reason="stopped by anna"),
        replace(stopped, reason="stopped by ben and anna"),
        replace(failed, reason="brakes on"),
        replace(failed, reason="stopped by ben; brakes on"),
    ]
    for second, state in enumerate(told):
        for tenth in range(20):
            history.add_state(state, (20 * second + tenth) * NS_PER_S // 10)
    assert [event.text for event in reversed(history.events) if event.kind in ("disengaged", "fault")] == [
        "disengaged: stopped by anna",
        "disengaged: stopped by ben and anna",
        "fault: brakes on",
        "fault: stopped by ben; brakes on",
    ]


def test_a_stop_that_a_page_repeats_until_it_is_acknowledged_is_one_event_and_a_later_one_another() -> None:
    history = History()
    for second in (0, 1, 2, 3, 4, 9):
        history.note_once("stop", "stop asked by page 1", second * NS_PER_S)
    assert [event.t_ns for event in history.events] == [9 * NS_PER_S, 0]


def test_silence_is_noted_when_it_begins_and_when_it_ends() -> None:
    history = History()
    for tenth in range(100):
        heard_tenth = tenth if tenth < 20 or tenth >= 60 else 20
        history.watch_silence(heard_tenth * NS_PER_S // 10, tenth * NS_PER_S // 10)
    assert [(event.kind, event.text) for event in history.events] == [
        ("link", "the remote site answers again after 4.0 s"),
        ("fault", "the remote site has fallen silent"),
    ]
