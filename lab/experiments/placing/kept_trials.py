"""Trials that are done, kept in a file line by line: hours of work that an interruption does not lose."""

from pathlib import Path

import msgspec

from common.errors import ConfigError
from lab.experiments.placing.trial import Conditions, TrialResult

FILE = "trials.jsonl"


class _Line(msgspec.Struct, frozen=True):
    version: str
    conditions: Conditions
    result: TrialResult


class KeptTrials:
    """The trials in `folder` that this version of the program has done.

    A last line that was cut off, as by a kill, does not count. ConfigError when the file cannot be read.
    """

    def __init__(self, folder: Path, version: str) -> None:
        self._path, self._version = folder / FILE, version
        self._lines = self._read()
        self.results = {line.conditions: line.result for line in self._lines if line.version == version}

    def keep(self, conditions: Conditions, result: TrialResult) -> None:
        """Add a trial to the file; OSError when that fails."""
        self.results[conditions] = result
        line = msgspec.json.encode(_Line(self._version, conditions, result))
        with self._path.open("ab") as file:
            file.write(line + b"\n")

    def _read(self) -> list[_Line]:
        try:
            *whole, cut_off = self._path.read_bytes().split(b"\n")
        except FileNotFoundError:
            return []
        except OSError as error:
            raise ConfigError(f"{self._path} cannot be read ({error}); remove it and run again") from error
        try:
            lines = [msgspec.json.decode(line, type=_Line) for line in whole]
            if cut_off:
                self._path.write_bytes(b"".join(line + b"\n" for line in whole))
        except (msgspec.MsgspecError, OSError) as error:
            raise ConfigError(f"{self._path} cannot be used ({error}); remove it and run again") from error
        return lines
