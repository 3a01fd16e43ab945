"""Runs 'farhand remote' and records its control cycles: `python recording_remote.py FILE --set ...`."""

import sys
from pathlib import Path

from farhand.__main__ import main
from remote_site.teleop.cycle import Command, CycleInput
from remote_site.teleop.pipeline import TeleopPipeline
from tests.remote_site.teleop.cycle_log import write_cycle


def record(path: Path) -> None:
    """Have every cycle of this process and its children appended to a file."""
    stream, true_cycle = path.open("ab"), TeleopPipeline.cycle

    def cycle(self: TeleopPipeline, given: CycleInput) -> Command:
        command = true_cycle(self, given)
        write_cycle(stream, given, command)
        return command

    TeleopPipeline.cycle = cycle  # type: ignore[method-assign]


if __name__ == "__main__":
    record(Path(sys.argv[1]))
    sys.argv = ["farhand", "remote", *sys.argv[2:]]
    main()
