"""Log lines: text or JSON, and a priority where the journal reads them."""

import json
import os
import subprocess
import sys

import pytest

PROGRAM = """
import sys, os, structlog
from common.process.service import LogFormat, start_log
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
