"""A non-blocking serial port, raw 8N1: reads what has arrived, writes what the line takes."""

import fcntl
import os
import struct
import termios
from typing import Protocol

from common.errors import DriverError


class Port(Protocol):
    """Bytes to and from the controller."""

    def read(self) -> bytes: ...

    def write(self, data: bytes) -> None: ...


class SerialPort:
    """A serial device, or a pseudo-terminal."""

    def __init__(self, handle: int) -> None:
        self._handle = handle

    def read(self) -> bytes:
        """Read what has arrived, b"" without anything; DriverError when the device is gone.

        Bytes are counted first: to read or poll an empty line waits for the kernel's worker that moves its bytes, even
        of a non-blocking device, and on a busy machine that takes longer than a call may.
        """
        try:
            waiting = struct.unpack("i", fcntl.ioctl(self._handle, termios.FIONREAD, bytes(4)))[0]
            return os.read(self._handle, waiting) if waiting else b""
        except BlockingIOError:  # another program has read them
            return b""
        except OSError as error:
            raise DriverError(f"the serial line is gone: {error.strerror}") from error

    def write(self, data: bytes) -> None:
        """Hand bytes to the device; what it does not take is lost, as on the line, and will be sent again."""
        try:
            os.write(self._handle, data)
        except BlockingIOError:
            return
        except OSError as error:
            raise DriverError(f"the serial line is gone: {error.strerror}") from error


def open_port(path: str, baud: int) -> SerialPort:
    """Open a serial device; DriverError names what is missing."""
    try:
        handle = os.open(path, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK | os.O_CLOEXEC)
        make_raw(handle, baud)
    except (OSError, termios.error) as error:
        raise DriverError(f"cannot open the serial line {path}: {error}") from error
    return SerialPort(handle)


def make_raw(handle: int, baud: int) -> None:
    """Eight bits, no parity, one stop bit, no translation, no echo, no flow control."""
    speed = getattr(termios, f"B{baud}", None)
    if speed is None:
        raise DriverError(f"{baud} is not a baud rate of serial ports; set 57600")
    control = termios.tcgetattr(handle)[6]
    termios.tcsetattr(
        handle, termios.TCSANOW, [0, 0, termios.CS8 | termios.CREAD | termios.CLOCAL, 0, speed, speed, control]
    )
    termios.tcflush(handle, termios.TCIOFLUSH)
