"""The doctor's figures of a bad link between two hosts on this machine: what was set is what it measures."""

import json
import re
import subprocess
import sys

import pytest

from lab.stage.network.namespaces import why_not

NUMBER = r"([0-9.]+)"
PATIENCE_S = 150.0

pytestmark = [pytest.mark.long, pytest.mark.skipif(bool(why_not()), reason="no right to namespaces and TUN devices")]


def measured(protocol: str, *more: str, **impairment: float) -> dict[str, str]:
    """The sentences of the doctor's findings, by check, for a link of this impairment."""
    command = [sys.executable, "-m", "tests.faults.probed_cell", protocol, json.dumps(impairment), *more]
    done = subprocess.run(command, check=False, capture_output=True, text=True, timeout=PATIENCE_S)
    assert done.returncode == 0, done.stderr[-4000:]
    return {finding["check"]: finding["sentence"] for finding in json.loads(done.stdout)["findings"]}


def figure(sentence: str, words: str) -> float:
    """The number at the place of # in these words."""
    found = re.search(words.replace("#", NUMBER), sentence)
    assert found is not None, sentence
    return float(found[1])


def test_delay_and_loss_are_what_was_set() -> None:
    found = measured("quic", delay_ms=20.0, loss=0.1)
    for check in ("link quic", "link tls"):
        assert figure(found[check], "round trip # ms at least") == pytest.approx(40.0, rel=0.2, abs=4.0)
    # Of 300 probes, 10 % lost each way have a standard deviation of 1.7 %; a busy machine loses some of its own.
    there, back = (figure(found["link quic"], rf"{way} jitter [0-9.]+ ms, loss #%") for way in ("there", "back"))
    assert there == pytest.approx(10.0, abs=8.0)
    assert back == pytest.approx(10.0, abs=8.0)
    assert "loss hidden by TCP" in found["link tls"]


def test_a_narrow_link_is_measured_both_ways_and_an_engaged_arms_is_not_loaded() -> None:
    found = measured("tls", delay_ms=20.0, mbit_s=5.0)
    for way in ("there", "back"):
        carried = figure(found["link tls"].partition(way)[2], r"carries # Mbit/s")
        assert carried == pytest.approx(5.0, rel=0.25)
    assert "QUIC was tried and not measured" in found["link quic"]
    engaged = measured("tls", "engaged", delay_ms=20.0)
    assert "carries" not in engaged["link tls"]
    assert "the arm is engaged" in engaged["link tls"]
    assert "not measured: the arm is engaged" in engaged["pictures"]
