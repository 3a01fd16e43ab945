"""The exception tree: everything Farhand raises on purpose.

FarhandError
├── ConfigError       a configuration file or setting is wrong; every mistake at once, each with its cure
├── MessageError      bytes from the wire are not a valid message
├── TransportError    a session cannot be opened, or a request had no answer
│   └── RefusedError  the other side cannot speak with this one, and says why
├── CameraError       a camera is missing, ended or gives no frames
├── CalibrationError  control points, a plate or a rig file cannot give a calibration
├── ModelError        a robot model is unusable
├── DriverError       a robot driver refuses, fails or reports a fault
├── ProcessError      a child process died or did not become ready
└── InterruptionError a person ended the work before it was done
"""


class FarhandError(Exception):
    """Base of every error that names its cure; the command line prints it without a traceback."""


class ConfigError(FarhandError):
    """A configuration is wrong; the text lists every mistake with line and cure."""


class MessageError(FarhandError):
    """Bytes are not a valid message; `reason` is a short word for counting rejections."""

    def __init__(self, reason: str, detail: str) -> None:
        super().__init__(f"{reason}: {detail}")
        self.reason = reason


class TransportError(FarhandError):
    """A session cannot be opened, an endpoint is refused, or a request had no answer."""


class RefusedError(TransportError):
    """The other side answered that it cannot understand this one, or this one cannot understand the answer."""


class CameraError(FarhandError):
    """A camera or recording cannot be opened or has stopped giving frames."""


class CalibrationError(FarhandError):
    """A calibration cannot be computed or read, and why."""


class ModelError(FarhandError):
    """A robot model cannot be read or lacks what control needs."""


class DriverError(FarhandError):
    """A robot driver refuses a call, failed, or reports a fault of the robot."""


class ProcessError(FarhandError):
    """A child process died, or did not become ready in time."""


class InterruptionError(FarhandError):
    """A person ended the work before it was done; what was done is kept, and nothing has failed."""
