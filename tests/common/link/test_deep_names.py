"""A name of many thousand chunks that a neighbour declares ends no process when that neighbour goes."""

import multiprocessing
import os
import time
from pathlib import Path

import pytest

from common.link.channels import STATE
from common.link.session_settings import STACK_BYTES
from common.link.transport import open_link
from lab.stage.waiting import until
from tests.common.link.secured_cell import CELL, ROBOT_STATE, dishonest, free_port

CHUNKS = 8000
SERVED_S, GONE_S = 60.0, 2.0


def publish(endpoint: str) -> None:
    """What a site does, for as long as the test needs it."""
    os.environ.pop("RUST_MIN_STACK", None)  # another test's
    with open_link(listen=(endpoint,)) as link:
        state, until_s = link.publisher(STATE, CELL), time.monotonic() + SERVED_S
        while time.monotonic() < until_s:
            state.put(ROBOT_STATE)
            time.sleep(0.01)


def declare(endpoint: str) -> None:
    """What a neighbour may do, who then goes without a word."""
    os.environ["RUST_MIN_STACK"] = str(STACK_BYTES)
    with dishonest(endpoint, Path(), None) as session:
        until(session.info.links)
        session.declare_subscriber("/".join("x" * CHUNKS), lambda _: None)
        time.sleep(0.5)
        os._exit(0)


@pytest.mark.slow
def test_a_site_outlives_a_neighbour_whose_name_has_thousands_of_chunks() -> None:
    endpoint, spawn = f"tcp/127.0.0.1:{free_port()}", multiprocessing.get_context("spawn")
    site, neighbour = (spawn.Process(target=act, args=(endpoint,)) for act in (publish, declare))
    site.start()
    try:
        neighbour.start()
        neighbour.join()
        assert neighbour.exitcode == 0
        time.sleep(GONE_S)  # the neighbour's lease is over
        assert site.is_alive()
        with open_link(connect=(endpoint,)) as link:
            until(link.latest(STATE, CELL).take)
    finally:
        site.kill()
        site.join()
