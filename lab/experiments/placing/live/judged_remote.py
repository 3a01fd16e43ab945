"""Runs Farhand's command line with the judge of a trial in the process of its simulated cell.

python -m lab.experiments.placing.live.judged_remote OUT remote --set ...
"""

import sys
from functools import partial
from pathlib import Path
from unittest.mock import patch

from common.process.children import Heartbeat
from common.process.service import StopFlag
from farhand.__main__ import main
from lab.experiments.placing.live.judgement import judged
from remote_site.config import RemoteConfig
from remote_site.runtime import app
from remote_site.simulation.memory import CellMemory
from remote_site.simulation.process import SimulatedCell, run_cell


def run() -> None:
    """The command line of Farhand, with a cell that is judged; the judgement is in the file OUT once the site ends."""
    with patch.object(app, "run_cell_child", partial(run_judged_cell, Path(sys.argv.pop(1)))):
        main()


def run_judged_cell(
    out: Path, config: RemoteConfig, memory: CellMemory, should_stop: StopFlag, heartbeat: Heartbeat
) -> None:
    """The process of the simulated cell, which the judge watches."""
    cell = SimulatedCell(config.simulation, config.robot, memory)
    with judged(config, out, cell) as stepped:

        def beat() -> None:
            stepped()
            heartbeat.beat()

        run_cell(cell, should_stop, beat)


if __name__ == "__main__":
    run()
