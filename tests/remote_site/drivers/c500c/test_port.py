"""The serial port: what has arrived, at once; an empty line is never waited for, and one that is gone is a fault."""

import os
import time

import pytest

from common.errors import DriverError
from remote_site.drivers.c500c.emulation import Terminal
from remote_site.drivers.c500c.port import Port, SerialPort, open_port


def arrived(port: Port, count: int) -> bytes:
    """So many bytes, which the kernel's worker moves in a time of its own."""
    got, end_s = port.read(), time.monotonic() + 5.0
    while len(got) < count and time.monotonic() < end_s:
        time.sleep(0.001)
        got += port.read()
    return got


def test_a_terminal_carries_bytes_as_they_are() -> None:
    terminal = Terminal.create()
    port, far = open_port(terminal.path, 57600), terminal.port
    port.write(bytes(range(256)))
    assert arrived(far, 256) == bytes(range(256))
    far.write(b"\r\n\x03\x04\xa5")
    assert arrived(port, 5) == b"\r\n\x03\x04\xa5"
    assert port.read() == b""


def test_an_empty_line_is_not_read_because_the_kernel_would_wait_for_its_worker(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def read(handle: int, size: int) -> bytes:
        raise AssertionError(f"{handle} is read for {size} bytes")

    port = open_port(Terminal.create().path, 57600)
    monkeypatch.setattr(os, "read", read)
    assert port.read() == b""


def test_a_line_that_is_gone_is_a_fault() -> None:
    ours, theirs = os.openpty()
    port = SerialPort(theirs)
    os.close(ours)
    with pytest.raises(DriverError, match="the serial line is gone"):
        port.read()
    os.close(theirs)
