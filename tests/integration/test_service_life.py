"""A daemon's life as systemd sees it: ready once, its watchdog fed, an end that is announced, or a child that hangs."""

import os
import re
import signal
import time
import urllib.request
from functools import partial
from pathlib import Path

import pytest

from tests.integration.pair import Pair
from tests.integration.sites import alive, child_of, descendants

FIGURES = {"farhand_control_missed_ticks_total", "farhand_session_state", "farhand_video_frames_total"}
END_S = 30.0  # two where a machine has nothing else to do
GONE_S = 3.0  # two where a machine has nothing else to do; it was four to five


@pytest.mark.slow
def test_figures_are_served_and_the_site_goes_on_when_they_die(pair: Pair) -> None:
    process, sites = pair.remote(), pair.sites
    sites.wait("figures of control and video", lambda: figures_at(pair.metrics_port) >= FIGURES)
    os.kill(child_of(process, "farhand-metrics"), signal.SIGKILL)
    sites.wait("the site to say so", lambda: any("continues without it" in line for line in process.lines))
    told = len(sites.record.states)
    sites.wait("control to go on", lambda: len(sites.record.states) > told + 25)
    assert process.exit_code is None


@pytest.mark.slow
def test_both_sites_tell_systemd_of_their_life_end_soon_after_sigterm_and_leave_nothing(pair: Pair) -> None:
    _, local = processes = pair.following()
    sites = pair.sites
    started = [p for site in processes for p in (site.pid, *descendants(site.pid))]
    for site in processes:
        told = sites.systemd[site.pid].words
        sites.wait("the watchdog to be fed", partial(lambda words: len(words) > 5, told))
    for site in processes:
        os.kill(site.pid, signal.SIGTERM)
    sites.wait("both to end", lambda: all(site.exit_code is not None for site in processes), END_S)
    assert [site.exit_code for site in processes] == [0, 0]
    sites.wait("no process to be left", lambda: not any(alive(p) for p in started), END_S)
    assert all(list(site.lines)[-1].endswith('event=ended reason="it was asked to end"') for site in processes)
    assert not [line for site in processes for line in site.lines if "fault" in line and "faults: 0" not in line]
    for site in processes:
        said = [line for line in site.lines if "event=summary" in line]
        engaged = any(re.search(r'run=".* engaged (once|\d+ times) for ', line) for line in said)
        assert engaged or site is local  # which may not have heard of it yet
        assert (3 if engaged else 2) <= len(said) <= 5
        assert said[-1] in list(site.lines)[-5:]
    for site in processes:
        told = sites.systemd[site.pid].words
        sites.wait("the last word", partial(lambda words: words[-1] == "STOPPING=1", told), END_S)
        assert told[0] == "READY=1"
        assert set(told[1:-1]) == {"WATCHDOG=1"}


@pytest.mark.long
def test_the_local_site_ends_soon_although_the_remote_one_is_gone(pair: Pair) -> None:
    remote, local = pair.following()
    gone = [remote.pid, *descendants(remote.pid)]
    for pid in gone:
        os.kill(pid, signal.SIGSTOP)  # as a host without power: nothing says that it is gone
    try:
        began = time.monotonic()
        os.kill(local.pid, signal.SIGTERM)
        pair.sites.wait("its end", lambda: local.exit_code is not None, END_S)
        assert time.monotonic() - began < GONE_S
    finally:
        for pid in gone:
            os.kill(pid, signal.SIGKILL)
    assert local.exit_code == 0
    pair.sites.wait("the remote site's end", lambda: remote.exit_code is not None, END_S)


@pytest.mark.long
def test_a_child_that_stands_still_ends_the_remote_site_so_that_systemd_starts_it_again(pair: Pair) -> None:
    process, sites = pair.remote(), pair.sites
    systemd = sites.systemd[process.pid]
    sites.wait("readiness", lambda: "READY=1" in systemd.words)
    video = child_of(process, "farhand-video")
    os.kill(video, signal.SIGSTOP)
    try:
        sites.wait("the remote site to end", lambda: process.exit_code is not None)
    finally:
        if Path(f"/proc/{video}").exists():
            os.kill(video, signal.SIGCONT)
    assert process.exit_code == 1
    assert "process video hangs" in process.last_error()
    sites.wait("the last word", lambda: systemd.words[-1] == "STOPPING=1", END_S)


def figures_at(port: int) -> set[str]:
    """The names of the figures that are served now; none while no process serves."""
    try:
        with urllib.request.urlopen(f"http://127.0.0.1:{port}/metrics", timeout=20) as answer:
            page = answer.read().decode()
    except OSError:
        return set()
    return {line.partition("{")[0].partition(" ")[0] for line in page.splitlines() if not line.startswith("#")}
