"""The A465's controller, emulated by a process of neither site: `python -m tests.faults.emulated_robot FOLDER`.

It links its serial line as `line` in the folder, and keeps a record of its motion there.
"""

import sys
import time
from pathlib import Path

import numpy as np

from common.process.service import StopFlag
from remote_site.drivers.c500c.emulation import Emulation, Terminal, run_emulation
from remote_site.drivers.c500c.emulator import Emulated, EmulatedController
from remote_site.kinematics.config import RobotConfig
from tests.faults.recording_driver import READ, RECORD

OBJECT_M = 0.03  # between the fingers


def run(folder: Path) -> None:
    """Be the controller until asked to stop."""
    controller = EmulatedController(RobotConfig().start, Emulated(object_m=OBJECT_M))
    terminal, should_stop = Terminal.create(), StopFlag()
    should_stop.install()
    with (folder / "record").open("ab", buffering=0) as record_of:

        def note() -> None:
            record = np.zeros((), RECORD)
            record["kind"], record["t_ns"] = READ, time.monotonic_ns()
            record["motion"][0], record["motion"][1] = controller.player.q, controller.dq
            record_of.write(record.tobytes())

        note()
        (folder / "line").symlink_to(terminal.path)
        run_emulation(Emulation(controller, time.monotonic_ns()), terminal, should_stop, note)


if __name__ == "__main__":
    run(Path(sys.argv[1]))
