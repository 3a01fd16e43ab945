"""A viewer that declares what takes much memory ends the process that serves viewers, and nothing else."""

import itertools
import multiprocessing
from pathlib import Path
from unittest.mock import patch

from common.link.config import ViewersConfig
from common.link.transport import open_link
from common.link.viewers import Site
from common.messages.requests import EngagementAction
from common.process import viewers as process
from common.process.children import Heartbeat
from common.process.service import StopFlag
from lab.stage.waiting import until
from tests.common.link.secured_cell import ANNA, CELL, Cell, dishonest, free_port, reply_to, secured

LITTLE_BYTES = 1000 << 20  # so that the test does not take as much either; half of it are stacks of threads
DEEP = "/".join("x" * 8000)  # Zenoh keeps every beginning of a key expression: 64 MB
NICE = 0


def serve(viewers: ViewersConfig, site: Site) -> None:
    """What the site has a process do."""
    with patch.multiple(process, MOST_MEMORY_BYTES=LITTLE_BYTES, NICE=NICE):
        process.run_viewers(viewers, "viewers", site, StopFlag(), Heartbeat())


def test_a_viewer_that_takes_all_memory_it_gets_ends_who_serves_viewers_alone(pki: Path, cell: Cell) -> None:
    endpoint = f"tls/127.0.0.1:{free_port()}"
    viewers = ViewersConfig(listen=endpoint, tls=secured(pki, "viewers-remote").tls)
    site = Site(CELL, (cell.endpoint,), secured(pki, "remote"))
    serving = multiprocessing.get_context("spawn").Process(target=serve, args=(viewers, site))
    serving.start()
    try:
        with dishonest(endpoint, pki, "viewer") as viewer:
            until(viewer.info.links)
            for number in itertools.count():
                if not serving.is_alive() or number == 10:
                    break
                viewer.declare_subscriber(f"{number}/{DEEP}", lambda _: None)
            until(lambda: not serving.is_alive())
    finally:
        serving.kill()
        serving.join()
    with open_link(connect=(cell.endpoint,), security=secured(pki, f"operator.{ANNA}")) as anna:
        assert reply_to(anna, EngagementAction.STOP).done
