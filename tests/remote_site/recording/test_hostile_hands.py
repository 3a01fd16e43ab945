"""Whatever an operator sends while a recorder runs: the recording goes on, its files can be read, and stay small."""

import random
from collections import Counter
from itertools import count
from pathlib import Path

import msgspec
import pytest

from common.link.channels import HAND, SHOWN
from common.messages.codec import encode
from common.messages.hand import ClockSync, HandArm
from common.recording.reader import KeptMessage, RecordingReader
from common.recording.records import MOST_TIME_NS
from remote_site.recording.message_budget import KEPT_BYTES_PER_S
from tests.remote_site.driven_loop import CONFIG
from tests.remote_site.hostile_hand import HostileHand
from tests.remote_site.recording.recorded_site import CELL, KEY, RecordedSite
from tests.remote_site.remote_loop import hand

LARGEST, NOISY_S = 2**63 - 1, 3
OTHERS = HAND.key_for(CELL, operator="ben")


def began(folder: Path) -> RecordedSite:
    folder.mkdir(exist_ok=True)
    made = RecordedSite(folder)
    made.loop.link.activate(CONFIG.robot.start)
    made.run(0.1)
    return made


@pytest.fixture
def site(tmp_path: Path) -> RecordedSite:
    return began(tmp_path)


def sync(remote_minus_local_ns: int) -> ClockSync:
    return ClockSync(remote_minus_local_ns=remote_minus_local_ns, uncertainty_ns=0, measured_ns=0)


def send(site: RecordedSite, sample: HandArm) -> None:
    """A sample of an operator without the lease arrives, and the site goes on for a moment."""
    site.tap.note_message(OTHERS, encode(sample), sent=False)
    site.idle(0.2)


def published_since_1970_ns(site: RecordedSite, topic: str) -> list[int]:
    """When the messages of a topic were sent, once the recording has ended; every message of it is read."""
    site.end()
    (path,) = site.files
    with RecordingReader(path) as reader:
        epoch_ns = reader.epoch_minus_clock_ns
        return [message.published_ns + epoch_ns for message in reader.messages() if message.topic == topic]


@pytest.mark.parametrize(
    ("capture_ns", "sent_ns", "offset_ns", "expected_ns"),
    [
        (LARGEST, None, 0, MOST_TIME_NS - 1),
        (2**62, None, 0, MOST_TIME_NS - 1),
        (LARGEST, LARGEST, LARGEST, MOST_TIME_NS - 1),
        (0, 0, -LARGEST, 0),
    ],
)
def test_a_sample_of_any_time_leaves_a_recording_that_goes_on_and_can_be_read(
    site: RecordedSite, capture_ns: int, sent_ns: int | None, offset_ns: int, expected_ns: int
) -> None:
    sample = hand(5, capture_ns, clock=sync(offset_ns))
    send(site, msgspec.structs.replace(sample, sent_ns=sent_ns))
    assert site.recorder.state().writing
    assert published_since_1970_ns(site, "/hand/ben") == [expected_ns]


def test_any_samples_that_the_wire_accepts_leave_a_recording_that_can_be_read(site: RecordedSite) -> None:
    hostile, numbers = HostileHand(1), count()
    for _ in range(5):
        for _ in range(20):
            sample = hostile.sample(next(numbers), site.clock.now_ns())
            site.tap.note_message(OTHERS, encode(sample), sent=False)
        site.idle(1.0)
    assert site.recorder.state().writing
    assert len(published_since_1970_ns(site, "/hand/ben")) == next(numbers)


def kept_after_noise(site: RecordedSite, noise: int) -> tuple[int, list[KeptMessage]]:
    """The bytes of the recording and its messages, after seconds with so many noisy hand samples of ben's each tick."""
    chance = random.Random(1)  # noqa: S311  # noise, the same each time
    for _ in range(250 * NOISY_S):
        for _ in range(noise):
            site.tap.note_message(OTHERS, chance.randbytes(4096), sent=False, refused=True)
        site.loop.tick()
        site.note()
        site._after_tick(recorder_lives=True)
    site.end()
    (path,) = site.files
    with RecordingReader(path) as reader:
        return path.stat().st_size, list(reader.messages())


@pytest.mark.slow
def test_noise_of_an_operator_without_the_lease_leaves_a_recording_small_and_whole(tmp_path: Path) -> None:
    quiet, noisy = (began(tmp_path / name) for name in ("quiet", "noisy"))
    (usual, _), (size, messages) = kept_after_noise(quiet, 0), kept_after_noise(noisy, 16)
    assert size < usual + 2 * KEPT_BYTES_PER_S * (NOISY_S + 1)
    topics = Counter(message.topic for message in messages)
    assert topics[KEY] == sum(1 for m in messages if m.topic == "/hand/operator-7") >= 30 * NOISY_S
    said = [m.data for m in messages if m.topic == "/log" and b"are not recorded" in m.data]
    assert len(said) == 1
    assert b"of ben" in said[0]
    assert noisy.recorder.lost == 0


def test_noise_at_the_video_endpoint_is_bounded_and_said_too(site: RecordedSite) -> None:
    shown, sent = SHOWN.key_for(CELL, operator="ben"), 4 * 250 * NOISY_S
    for _ in range(250 * NOISY_S):
        for _ in range(4):
            site.video.note_message(shown, bytes(4096), sent=False, refused=True)
        site.idle(0.004)
    site.end()
    with RecordingReader(site.files[0]) as reader:
        messages = list(reader.messages())
    kept = sum(message.topic == shown for message in messages)
    assert 0 < kept * 4096 < KEPT_BYTES_PER_S * (NOISY_S + 2) < sent * 4096
    assert sum(b"are not recorded" in message.data for message in messages if message.topic == "/log") == 1
