"""Prints what a cell does, twice a second: python examples/cell_state.py [ENDPOINT] [CELL] [SECONDS]"""

import sys
import time

from common.link.channels import STATE
from common.link.transport import open_link


def main(endpoint: str = "tcp/127.0.0.1:7447", cell: str = "lab", seconds: str = "10") -> None:
    """Listen for so long."""
    end = time.monotonic() + float(seconds)
    with open_link(connect=(endpoint,)) as link:
        states = link.latest(STATE, cell)
        while time.monotonic() < end:
            time.sleep(0.5)
            if (state := states.take()) is not None:
                joints = " ".join(f"{q:+.3f}" for q in state.q)
                print(f"{state.state.value}: {state.reason}; joints {joints} rad", flush=True)


if __name__ == "__main__":
    main(*sys.argv[1:])
