"""Log lines: text or JSON, a priority where the journal reads them, written without holding up who logs."""

import json
import os
import subprocess
import sys

import pytest
from structlog.testing import capture_logs

from common.errors import MessageError
from common.process.log import RefusalLog

PROGRAM = """
import sys, os, structlog
from common.process.log import LogFormat, start_log
if sys.argv[2] == "journal":
    there = os.fstat(2)
    os.environ["JOURNAL_STREAM"] = f"{there.st_dev}:{there.st_ino}"
start_log("remote", LogFormat(sys.argv[1]))
structlog.get_logger().warning("late", late_ms=12, reason='he said "no"')
structlog.get_logger().info("ready")
"""


def lines(log_format: str, reader: str) -> list[str]:
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM, log_format, reader],
        check=True,
        capture_output=True,
        text=True,
        env=os.environ | {"JOURNAL_STREAM": "1:2"},  # another process's: what a child inherits whose output is led away
    )
    return done.stderr.splitlines()


def test_json_lines_hold_every_field() -> None:
    late, ready = (json.loads(line) for line in lines("json", "file"))
    assert late.pop("time")
    assert late == {"level": "warning", "site": "remote", "event": "late", "late_ms": 12, "reason": 'he said "no"'}
    assert (ready["level"], ready["event"]) == ("info", "ready")


def test_text_lines_begin_with_their_level() -> None:
    late, ready = lines("text", "file")
    assert late.startswith("level=warning time=")
    assert "site=remote event=late" in late
    assert ready.startswith("level=info ")


@pytest.mark.parametrize("log_format", ["text", "json"])
def test_the_journal_is_told_the_level_of_every_line(log_format: str) -> None:
    late, ready = lines(log_format, "journal")
    assert late.startswith("<4>")
    assert ready.startswith("<6>")


SPOKEN = """
import structlog
from common.process.log import LogFormat, start_log
start_log("remote", LogFormat({log_format!r}))
structlog.get_logger().warning("robot fault", native="\\x1b[31m", reason={said!r})
"""
SAID = "red \x1b[31m\x9b31m, bell \x07, \x00, back\rlevel=info event=forged\nlevel=info, \u202etxet\u2066 \u2028 é…"
ACTING = [
    *(chr(code) for code in (*range(0x20), *range(0x80, 0xA0))),
    *"\u061c\u200e\u200f\u2028\u2029\u202a\u202e\u2066\u2069",
]


@pytest.mark.parametrize("log_format", ["text", "json"])
def test_what_a_driver_says_neither_acts_on_a_terminal_nor_begins_a_line(log_format: str) -> None:
    program = SPOKEN.format(log_format=log_format, said=SAID)
    written = subprocess.run([sys.executable, "-c", program], check=True, capture_output=True).stderr.decode()
    assert written.endswith("\n")
    assert not set(written[:-1]) & set(ACTING)


def test_a_text_line_shows_what_it_has_escaped() -> None:
    program = SPOKEN.format(log_format="text", said=SAID)
    written = subprocess.run([sys.executable, "-c", program], check=True, capture_output=True).stderr.decode()
    assert r"native=\x1b[31m" in written
    assert r"bell \x07, \x00, back\rlevel=info event=forged\nlevel=info, \u202etxet\u2066 \u2028 é…" in written


STRAYS = {
    "a child that fails": "children.start('driver', fail).process.join()",
    "a child that exits": "children.start('driver', leave).process.join()",
    "a thread that fails": "t = threading.Thread(target=fail); t.start(); t.join()",
    "a library that warns": "logging.getLogger('library').warning('it broke: %s', SAID)",
    "a library that fails": "logging.getLogger('library').error('it broke', exc_info=RuntimeError(SAID))",
    "the process that fails": "fail()",
}
STRAY = """
import logging, threading
from common.process.children import Children
from common.process.log import LogFormat, finish_log, start_log
SAID = {said!r}
def fail(*_): raise RuntimeError(SAID)
def leave(*_): raise SystemExit(SAID)
start_log("remote", LogFormat({log_format!r}))
children = Children("remote")
try:
    {act}
finally:
    finish_log()
"""


@pytest.mark.slow
@pytest.mark.parametrize("log_format", ["text", "json"])
@pytest.mark.parametrize("stray", STRAYS)
def test_tracebacks_and_what_libraries_say_neither_act_on_a_terminal_nor_begin_a_line(
    stray: str, log_format: str
) -> None:
    program = STRAY.format(log_format=log_format, said=SAID, act=STRAYS[stray])
    written = subprocess.run([sys.executable, "-c", program], check=False, capture_output=True).stderr.decode()
    assert r"\x1b[31m" in written or r"\u001b[31m" in written
    assert not set(written.replace("\n", "")) & set(ACTING)
    assert not [line for line in written.split("\n") if line.startswith("level=info")]


MANY_LINES = """
import structlog
from common.process.log import start_log
start_log("remote")
for number in range(2000):
    structlog.get_logger().info("line", number=number, padding=1000 * "x")
print("done", flush=True)
"""


def test_nobody_who_logs_waits_for_a_reader_and_no_line_is_lost() -> None:
    command = [sys.executable, "-c", MANY_LINES]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as program:
        assert program.stdout is not None
        assert program.stdout.readline() == "done\n"  # with 2 MB in the log, of which a pipe holds 64 kB
        assert program.stderr is not None
        numbers = [int(line.partition("number=")[2].split()[0]) for line in program.stderr]
    assert numbers == list(range(2000))


FORKING = """
import structlog
from common.process.children import Children
from common.process.log import start_log

def worker(should_stop, heartbeat):
    for number in range(200):
        structlog.get_logger().info("child", number=number)

start_log("remote")
children = Children("remote")
for _ in range(20):
    structlog.get_logger().info("parent")
    children.start("worker", worker).process.join()
structlog.get_logger().info("end")
"""


def test_every_line_of_a_process_and_of_its_children_is_written_once() -> None:
    done = subprocess.run([sys.executable, "-c", FORKING], check=True, capture_output=True, text=True)
    events = [line.partition("event=")[2].split()[0] for line in done.stderr.splitlines()]
    assert (events.count("parent"), events.count("child"), events.count("end")) == (20, 4000, 1)
    assert len(events) == 4021


def test_the_first_of_each_reason_is_logged_and_all_are_counted() -> None:
    refusals = RefusalLog("intent refused")
    with capture_logs() as log:
        for _ in range(30):
            refusals.note(MessageError("malformed", "no map"))
            refusals.note(MessageError("version", "6"))
    assert [(line["event"], line["log_level"]) for line in log] == [("intent refused", "warning")] * 2
    assert "no map" in log[0]["reason"]
    assert refusals.counts == {"malformed": 30, "version": 30}
