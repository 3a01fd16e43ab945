"""A passage for viewers to a cell on this host, followed as its process does."""

import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from common.link.config import ViewersConfig
from common.link.viewers import Site, open_passage
from tests.common.link.secured_cell import CELL, free_port, secured


@contextmanager
def watched(folder: Path, endpoints: Sequence[str], who: str = "remote", cell: str = CELL) -> Iterator[str]:
    """Let viewers watch whoever listens at these endpoints; where viewers connect."""
    endpoint = f"tls/127.0.0.1:{free_port()}"
    viewers = ViewersConfig(listen=endpoint, tls=secured(folder, f"viewers-{who}", cell).tls)
    ended = threading.Event()
    with open_passage(viewers, "viewers", Site(cell, endpoints, secured(folder, who, cell))) as passage:

        def follow() -> None:
            while not ended.wait(0.05):
                passage.follow()

        thread = threading.Thread(target=follow)
        thread.start()
        try:
            yield endpoint
        finally:
            ended.set()
            thread.join()
