"""A flag that signals set: however many come, and wherever they interrupt, what waits for it goes on."""

import os
import subprocess
import sys
import threading
import time

import pytest

from common.process.service import StopFlag

# Polls, waits and signals itself in one tight loop: the handler interrupts each of them at every place.
STORM = """
import os, signal
from common.process.service import StopFlag

for _ in range(400):
    stopped = StopFlag()
    stopped.install()
    sender = os.fork()
    if sender == 0:
        for _ in range(20):
            os.kill(os.getppid(), signal.SIGTERM)
        os._exit(0)
    while not stopped.wait(0.001) or not stopped():
        pass
    stopped.set()
    while os.waitpid(sender, os.WNOHANG) == (0, 0):
        stopped.wait(0.001)
        stopped.set()
print("came through")
"""
# What a handler may interrupt: the wait itself, where the interpreter holds the lock of an event.
WITHIN = """
import signal, sys
from common.process.service import StopFlag

stopped = StopFlag()
stopped.install()
raised = []

def interrupted(frame, event, _argument):
    if len(raised) < 50:
        raised.append(frame.f_lineno)
        signal.raise_signal(signal.SIGTERM)
    return interrupted

sys.settrace(interrupted)
for _ in range(20):
    stopped.set()
    stopped.wait(0.0)
    stopped()
sys.settrace(None)
print("came through", len(raised))
"""


@pytest.mark.slow
@pytest.mark.parametrize("program", [STORM, WITHIN], ids=["storm", "at every line"])
def test_thousands_of_signals_in_a_tight_loop_never_hang_what_waits(program):
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    run = subprocess.run(
        [sys.executable, "-c", program], env=environment, capture_output=True, text=True, timeout=60, check=False
    )
    assert run.stdout.startswith("came through"), run.stderr


def test_it_wakes_every_thread_that_waits_and_stays_set():
    stopped, woken = StopFlag(), []
    threads = [threading.Thread(target=lambda: woken.append(stopped.wait(30.0))) for _ in range(3)]
    for thread in threads:
        thread.start()
    stopped.set()
    stopped.set()
    for thread in threads:
        thread.join(30.0)
    assert woken == [True] * 3
    assert stopped.wait(0.0)
    assert stopped()


def test_it_waits_as_long_as_is_asked_and_no_longer():
    stopped, began = StopFlag(), time.monotonic()
    assert not stopped.wait(0.03)
    assert time.monotonic() - began >= 0.03
    assert not stopped.wait(0.0)
    assert not stopped.wait(-1.0)


def test_flags_that_are_let_go_leave_no_descriptor():
    before = len(os.listdir("/proc/self/fd"))
    for _ in range(100):
        StopFlag().set()
    assert len(os.listdir("/proc/self/fd")) <= before + 1
