"""A neighbour that asks and never reads: python -m tests.common.link.deaf_neighbour ENDPOINT FOLDER EVERY_S.

It is ben, with a good certificate. It prints a line once it has subscribed to what fills its link, and asks until it is
ended.
"""

import itertools
import sys
import time
from pathlib import Path

import zenoh

from common.link.channels import LOAD_ECHO, OWN_CLOCK, STOP
from common.messages.codec import encode
from common.messages.requests import ClockQuestion, StopRequest
from tests.common.link.secured_cell import BEN, CELL, dishonest

SMALL_BYTES = 4096
FOREVER_S = 3600.0


def read_no_more(_: zenoh.Sample) -> None:
    """Keep Zenoh's thread, which reads from the link."""
    time.sleep(FOREVER_S)


def main(endpoint: str, folder: Path, every_s: float) -> None:
    """Fall silent with the first message, and ask for answers that the other side has to wait with."""
    questions = (
        (OWN_CLOCK.key_for(CELL, operator=BEN), encode(ClockQuestion())),
        (STOP.key_for(CELL, operator=BEN), encode(StopRequest())),
    )
    with dishonest(endpoint, folder, f"operator.{BEN}", receive_buffer_bytes=SMALL_BYTES) as session:
        key = LOAD_ECHO.key_for(CELL, operator=BEN)
        filling = session.declare_subscriber(key, zenoh.handlers.Callback(read_no_more, indirect=False))
        print(f"{filling.key_expr} fills the link", flush=True)  # noqa: T201  # tells the test
        for question, payload in itertools.cycle(questions):
            session.get(
                question, lambda _: None, payload=payload, timeout=0.1, congestion_control=zenoh.CongestionControl.BLOCK
            )
            time.sleep(every_s)


if __name__ == "__main__":
    main(sys.argv[1], Path(sys.argv[2]), float(sys.argv[3]))
