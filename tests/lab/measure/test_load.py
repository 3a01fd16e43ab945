"""The table of processor time: by process and stage, and what of it only a demonstration needs."""

import os
import time

import pytest

from lab.measure.load import DRAWING, MAIN, NETWORK, shares, used_s

USED = {
    ("farhand-video", MAIN): 6.0,
    ("farhand-video", NETWORK): 0.5,
    ("farhand-cell", MAIN): 1.5,
    ("farhand-filmed", MAIN): 2.0,
    ("browser renderer", MAIN): 5.0,
}


def test_stages_are_shares_of_a_core_and_the_demonstrations_are_named_and_summed():
    figures = shares(USED, 10.0, drawn_s=4.0)
    assert figures["farhand-video, own work, core %"] == pytest.approx(20.0)
    assert figures[f"farhand-video, {DRAWING} (demonstration), core %"] == pytest.approx(40.0)
    assert figures["farhand-cell, own work (demonstration), core %"] == pytest.approx(15.0)
    assert figures["all, core %"] == pytest.approx(150.0)
    assert figures["the demonstration's own, core %"] == pytest.approx(75.0)
    assert figures["the demonstration's share, %"] == pytest.approx(50.0)


def test_drawing_takes_no_more_than_the_video_has_used():
    figures = shares(USED, 10.0, drawn_s=100.0)
    assert "farhand-video, own work, core %" not in figures
    assert figures["all, core %"] == pytest.approx(150.0)


def test_a_process_is_found_with_what_it_has_used():
    before = used_s({"this one": os.getpid()})
    began_s = time.process_time()
    while time.process_time() - began_s < 0.2:
        pass
    used = used_s({"this one": os.getpid()})
    assert used["this one", MAIN] - before["this one", MAIN] >= 0.15
