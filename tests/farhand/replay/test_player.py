"""What a page gets of a recording: the messages of its time, none of another, and no robot."""

import msgspec
import pytest
from mcap.reader import make_reader

from common.clock import NS_PER_S, FakeClock
from common.errors import RecordingError
from common.messages.hand import HandArm
from common.messages.requests import EngagementAction
from common.messages.robot import RobotState, SessionState
from common.messages.video import VideoFrame
from common.recording.config import RecordConfig
from common.recording.reader import RecordingReader
from farhand.replay.console import RecordingPlayer
from farhand.replay.playback import Playback
from farhand.replay.recorded_scene import RecordedScene
from local_site.console.model.frames import FrameSlots
from local_site.console.model.page_messages import Ask, Play
from local_site.console.model.seat import Visitor
from local_site.console.page import Page
from tests.farhand.replay.recorded_states import SECONDS, recorded_states
from tests.present import present
from tests.remote_site.driven_loop import CONFIG
from tests.remote_site.recording.recorded_site import CAMERA, RecordedSite


class EverySlot(FrameSlots):
    """Takes the next picture whenever it comes."""

    def wants_after(self, _view):
        return None


class CollectingPage(Page):
    """Stands in for a page: keeps what it is sent."""

    def __init__(self):
        self.visitor, self.slots = Visitor(1, "here"), EverySlot()
        self.said, self.kinds, self.frames = [], {}, []

    def send(self, **fields):
        self.said.append(fields)

    def newest(self, kind, text):
        self.kinds[kind] = msgspec.json.decode(text)

    def frame(self, frame):
        self.frames.append(frame)
        return True


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    return recorded_states(tmp_path_factory.mktemp("recorded"))


@pytest.fixture
def scene(recording, tmp_path):
    with RecordedScene(recording.file, tmp_path) as opened:
        yield opened


@pytest.fixture
def clock():
    return FakeClock(NS_PER_S)


@pytest.fixture
def player(scene, clock):
    return RecordingPlayer(scene, "a recording", Playback(clock, scene.begin_ns, scene.end_ns))


@pytest.fixture
def page(player):
    arrived = CollectingPage()
    player.hub.arrive(arrived)
    return arrived


def shown(player, page, clock, seconds=0.0):
    """What the page shows some time later."""
    clock.advance_ms(1000 * seconds)
    player.feed()
    player.tell()
    return page.kinds["situation"]


@pytest.mark.slow
def test_the_scene_has_states_hands_and_pictures_in_the_order_of_their_times(scene):
    times, messages = zip(*scene.shown(scene.begin_ns), strict=True)
    assert list(times) == sorted(times)
    assert {type(message) for message in messages} == {RobotState, HandArm, VideoFrame}
    assert (times[-1] - times[0]) / NS_PER_S > SECONDS - 0.2


def test_a_page_is_told_that_it_sees_a_recording_and_may_not_operate(page):
    hello = page.said[0]
    assert (hello["type"], hello["operate"]) == ("hello", False)
    assert hello["replay"]["name"] == "a recording"
    assert hello["replay"]["began"].startswith("2026-03-04 05:06:0")
    assert hello["replay"]["duration_s"] == pytest.approx(SECONDS, abs=0.1)


def test_the_page_shows_what_was_when_it_was(player, page, clock, recording):
    assert shown(player, page, clock, 1.0)["robot"]["state"] == SessionState.DISENGAGED.value
    situation = shown(player, page, clock, recording.engaged_s)
    assert situation["robot"]["state"] == SessionState.ENGAGED.value
    assert situation["robot"]["heard_ms"] < 40
    assert situation["hand"]["age_ms"] < 100
    assert page.frames
    assert page.kinds["replay"]["position_s"] == pytest.approx(1.0 + recording.engaged_s)


def test_events_lead_to_where_the_state_changed(scene, recording):
    engaged = [event for event in scene.events if event.words.startswith("engaged")]
    assert engaged[0].at_s == pytest.approx(recording.engaged_s, abs=0.1)
    assert any(event.kind == "episode" for event in scene.events)


def test_a_jump_back_shows_the_earlier_time_and_nothing_of_the_later(player, page, clock):
    later = shown(player, page, clock, 4.0)
    assert any("engaged" in event["text"] for event in later["events"])
    player.handle(page, Play(position_s=0.5), 0)
    earlier = shown(player, page, clock)
    assert earlier["robot"]["state"] == SessionState.DISENGAGED.value
    assert not any(event["text"].startswith("engaged") for event in earlier["events"])
    numbers = [frame.seq for frame in page.frames]
    assert numbers == sorted(numbers)


def test_a_pause_and_another_speed(player, page, clock):
    player.handle(page, Play(playing=False), 0)
    shown(player, page, clock, 5.0)
    assert page.kinds["replay"] | {"now_ms": 0} == {
        "type": "replay",
        "running": False,
        "speed": 1.0,
        "position_s": 0.0,
        "now_ms": 0,
        "jumps": 0,
        "trouble": "",
    }
    player.handle(page, Play(playing=True, speed=2.0), 0)
    shown(player, page, clock, 2.0)
    assert page.kinds["replay"]["position_s"] == 4.0


@pytest.mark.parametrize("action", list(EngagementAction))
def test_who_asks_for_the_robot_hears_that_there_is_none(player, page, action):
    player.handle(page, Ask(id=4, action=action), 0)
    reply = page.said[-1]
    assert (reply["id"], reply["what"], reply["done"]) == (4, action.value, False)
    assert "no robot is connected" in reply["reason"]
    assert "emergency stop" in reply["reason"]


def test_at_the_end_it_stands(player, page, clock):
    shown(player, page, clock, 10 * SECONDS)
    assert not page.kinds["replay"]["running"]
    assert page.kinds["replay"]["position_s"] == pytest.approx(SECONDS, abs=0.1)


def test_it_begins_when_the_first_page_comes_and_shows_a_later_one_its_pictures(player, clock):
    clock.advance_ms(30_000)
    first = CollectingPage()
    player.hub.arrive(first)
    shown(player, first, clock, 1.0)
    assert first.kinds["replay"]["position_s"] == 1.0
    player.handle(first, Play(playing=False), 0)
    later = CollectingPage()
    player.hub.arrive(later)
    shown(player, later, clock, 5.0)
    assert {frame.view for frame in later.frames} == {frame.view for frame in first.frames}
    assert later.kinds["replay"]["position_s"] == 1.0


def damaged(file, topic, out):
    """A copy of a recording in which the middle one of the chunks with this topic is spoilt."""
    with file.open("rb") as whole:
        summary = present(make_reader(whole).get_summary())
    (channel,) = (number for number, known in summary.channels.items() if known.topic == topic)
    chunks = [chunk for chunk in summary.chunk_indexes if channel in chunk.message_index_offsets]
    spoilt = chunks[len(chunks) // 2]
    content, at = bytearray(file.read_bytes()), spoilt.chunk_start_offset + spoilt.chunk_length // 2
    content[at : at + 40] = b"\xa5" * 40
    out.write_bytes(content)
    return out


def test_a_damaged_recording_stands_where_it_is_damaged_and_says_so(recording, tmp_path, clock):
    file = damaged(recording.file, f"/camera/{CAMERA}", tmp_path / "damaged.mcap")
    with RecordedScene(file, tmp_path) as scene:
        player = RecordingPlayer(scene, "damaged", Playback(clock, scene.begin_ns, scene.end_ns))
        page = CollectingPage()
        player.hub.arrive(page)
        for _ in range(12):
            shown(player, page, clock, 0.5)
        assert "damaged" in page.kinds["replay"]["trouble"]
        assert not page.kinds["replay"]["running"]
        with pytest.raises(RecordingError, match="is damaged"):
            list(scene.shown(scene.begin_ns))


def test_damage_among_the_events_costs_the_rest_of_them_and_nothing_else(recording, tmp_path):
    file = damaged(recording.file, "/log", tmp_path / "damaged.mcap")
    with RecordedScene(file, tmp_path) as scene, RecordedScene(recording.file, tmp_path) as whole:
        assert scene.events[:-1] == whole.events[: len(scene.events) - 1]
        assert "damaged" in scene.events[-1].words
        assert len(list(scene.shown(scene.begin_ns))) == len(list(whole.shown(whole.begin_ns)))


def test_a_jump_into_a_later_part_shows_what_was_before_it_from_the_part_before(tmp_path):
    site = RecordedSite(tmp_path, RecordConfig(split_minutes=0.1))
    site.loop.link.activate(CONFIG.robot.start)
    site.run(0.4)
    site.idle(7.0)
    site.end()
    first, second = sorted(site.out.iterdir())
    with RecordedScene(first, tmp_path) as scene, RecordingReader(second) as part:
        begin_ns, end_ns = part.span_ns
        assert scene.end_ns == end_ns
        times = [t_ns for t_ns, _ in scene.shown(begin_ns + NS_PER_S // 4)]
        assert times == sorted(times)
        assert begin_ns - NS_PER_S // 4 - 1 < times[0] < begin_ns, (
            "what was before the jump is shown, from the part before"
        )
        assert len(list(scene.shown(scene.begin_ns))) > len(times)
