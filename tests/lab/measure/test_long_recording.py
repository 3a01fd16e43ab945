"""What the measurement of an hour rests on: a long file that is like the short one, in which every view is found."""

import pytest

from common.recording.reader import RecordingReader
from farhand.replay.recorded_scene import RecordedScene
from lab.measure.recording.long_file import first_pictures_ns, write_long
from lab.measure.recording.opening import WatchedReplay, opening_figures, repair_figures
from lab.stage.processes import UnavailableError
from tests.farhand.replay.recorded_states import SECONDS, recorded_states
from tests.remote_site.recording.recorded_site import CAMERA

LONG_S = 40.0


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    folder = tmp_path_factory.mktemp("recorded")
    short, long = recorded_states(folder).file, folder / "long.mcap"
    write_long(short, long, LONG_S)
    return short, long


def test_the_long_file_has_the_short_ones_messages_again_and_again(files):
    short, long = files
    with RecordingReader(short) as one, RecordingReader(long) as other:
        rounds = (other.seconds - one.seconds) / one.seconds + 1
        assert LONG_S <= other.seconds < LONG_S + SECONDS
        assert other.document("remote.json") == one.document("remote.json")
        for topic in ("/cycle/input", f"/camera/{CAMERA}"):
            assert other.topics[topic] == pytest.approx(rounds * one.topics[topic], rel=0.05)
        times = [message.t_ns for message in other.messages(["/cycle/input"])]
        assert times == sorted(set(times))


def test_what_is_timed_is_what_is_shown(files, tmp_path):
    _, long = files
    figures = opening_figures(long, tmp_path, [0.0, 0.5, 1.0])
    assert 0.0 < figures["seek median s"] <= figures["seek largest s"]
    with RecordedScene(long, tmp_path) as scene, pytest.raises(UnavailableError, match="pictures of"):
        WatchedReplay(scene, {CAMERA, "another"}).show(first_pictures_ns(long)[CAMERA])


def test_a_cut_file_is_refused_and_repaired(files):
    _, long = files
    size = long.stat().st_size
    figures = repair_figures(long)
    assert all(seconds > 0.0 for seconds in figures.values())
    assert size - long.stat().st_size < 2_000_000
    with RecordingReader(long) as reader:
        assert reader.seconds > LONG_S - 2.0
