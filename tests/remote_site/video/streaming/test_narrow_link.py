"""A link that becomes too narrow for the pictures is reported in time, with what it carries and what they need."""

import pytest

from lab.measure.video.link import StreamRun
from remote_site.video.streaming.setting import StreamSetting
from remote_site.video.streaming.video_trouble import narrow_link
from tests.present import present
from tests.remote_site.video.streaming.test_adaptation import CONFIG, pictures

FULL = StreamSetting(80, 1.0, 30.0)
MBIT = 1e6 / 8


@pytest.mark.parametrize("mbit", [2.0, 20.0])
def test_a_link_that_becomes_too_narrow_is_reported_within_five_seconds(mbit):
    run = StreamRun(CONFIG, pictures(), 100.0)
    run.run(10.0)
    assert run.adaptation.trouble(run.now_ns) is None
    run.link.mbit_s = mbit
    run.run(5.0)
    assert run.adaptation.trouble(run.now_ns) is not None
    run.run(5.0)
    narrow = present(run.adaptation.trouble(run.now_ns))
    assert narrow.carries_mbit_s == pytest.approx(mbit, rel=0.2)
    assert narrow.needs_mbit_s == pytest.approx(29.0, rel=0.4)  # extrapolated from the small pictures that are sent
    run.link.mbit_s = 1000.0
    run.run(8.0)
    assert run.adaptation.trouble(run.now_ns) is None


def test_the_sentence_names_both_rates_and_what_is_sent_instead():
    sent = [StreamSetting(40, 0.5, 10.0), StreamSetting(60, 0.75, 30.0)] * 2
    narrow = present(narrow_link(1.84 * MBIT, 31.2 * MBIT, FULL, sent))
    assert narrow.reason.startswith(
        "the link carries 1.8 Mbit/s of pictures; the four views need about 31 Mbit/s at quality 80, full size, 30 "
        "fps: they are sent at quality 40, 50% of the size, 10 fps. Cure: "
    )
    assert len(narrow.reason) < 400
    assert "the view needs about 31 Mbit/s" in present(narrow_link(1.84 * MBIT, 31.2 * MBIT, FULL, sent[:1])).reason


def test_nothing_is_reported_while_all_is_sent_in_full():
    assert narrow_link(1.84 * MBIT, 31.2 * MBIT, FULL, [FULL] * 4) is None
