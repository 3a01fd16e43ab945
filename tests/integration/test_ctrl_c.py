"""Ctrl-C while both sites are starting: no failure, and nothing is left."""

import os
import signal
import subprocess
import sys
import time

import pytest

from lab.stage.waiting import until
from tests.integration.sites import PATIENCE_S, alive, descendants

PROCESSES = 6


@pytest.mark.long
def test_ctrl_c_before_engagement_is_no_failure_and_leaves_no_process() -> None:
    loopback = subprocess.Popen(
        [sys.executable, "-m", "farhand", "loopback", "--seconds", "0", "--tracker", "markers"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    try:
        until(lambda: len(descendants(loopback.pid)) >= PROCESSES, "its processes", PATIENCE_S)
        started = descendants(loopback.pid)
        assert len(started) >= PROCESSES
        time.sleep(1.0)
        os.kill(loopback.pid, signal.SIGINT)
        _, told = loopback.communicate(timeout=PATIENCE_S)
        assert loopback.returncode == 130
        assert told.splitlines()[-1] == "farhand: interrupted"
        assert not [pid for pid in started if alive(pid)]
    finally:
        loopback.kill()
        loopback.communicate()
