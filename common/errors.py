"""The exception tree: everything Farhand raises on purpose."""


class FarhandError(Exception):
    """Base of every error that names its cure; the command line prints it without a traceback."""


class ConfigError(FarhandError):
    """A configuration is wrong; the text lists every mistake with line and cure."""


class ConfigFileError(ConfigError):
    """The file of a configuration cannot be read at all."""


class MessageError(FarhandError):
    """Bytes are not a valid message; `reason` is a short word for counting rejections."""

    def __init__(self, reason: str, detail: str) -> None:
        super().__init__(f"{reason}: {detail}")
        self.reason = reason


class TransportError(FarhandError):
    """A session cannot be opened, an endpoint is refused, or a request had no answer."""


class SilenceError(TransportError):
    """Nobody answers at a cell, named as `whom`; who opened the link adds where."""

    def __init__(self, whom: str) -> None:
        super().__init__(f"nobody answered at {whom}: is the site that is asked running?")
        self.whom = whom


class RefusedError(TransportError):
    """Both sides cannot or may not talk to each other; the text gives the reason."""


class CameraError(FarhandError):
    """A camera or recording cannot be opened or has stopped giving frames."""


class TrackingError(FarhandError):
    """A recording was tracked to its end, and no arm was found in it."""


class CalibrationError(FarhandError):
    """A calibration cannot be computed or read."""


class ModelError(FarhandError):
    """A model, of a robot or a network for pictures, cannot be had or read, or lacks what is needed of it."""


class NotInstalledError(ModelError):
    """The configuration asks for a model or a runtime that is not installed; the text names the command for it."""


class DriverError(FarhandError):
    """A robot driver refuses a call, failed, or reports a fault of the robot."""


class ProcessError(FarhandError):
    """A child process died, or did not become ready in time."""


class RecordingError(FarhandError):
    """A recording cannot be made, read or repaired."""


class ExportError(FarhandError):
    """A recorded session cannot be exported as asked."""


class InterruptionError(FarhandError):
    """A person interrupted the work; what was done is kept, and nothing has failed."""
