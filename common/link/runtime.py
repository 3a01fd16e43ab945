"""Settings that Zenoh reads in the environment alone: its threads, and how long one waits for a closing connection.

Closing a TCP or TLS connection, Zenoh waits until the other side has acknowledged what was sent last, for ten seconds
if need be. It does so in a thread of which there is one for all connections that are accepted, with all of QUIC, one
for those that are made, and one for all sending. A far site that asked by TLS why it got no answer by QUIC so held up
the hand samples for a round trip and more; one that vanished meanwhile would for ten seconds.
"""

import os

THREADS = 3  # of each kind: so many connections may be closing at once and hold up no other
LINGER_S = 1
STACK_BYTES = 32 << 20  # a neighbour's names are forgotten chunk by chunk, one call within another
ENVIRONMENT = {
    "ZENOH_RUNTIME": f"({', '.join(f'{kind}: (worker_threads: {THREADS})' for kind in ('acc', 'net', 'tx', 'rx'))})",
    "TCP_LINGER_TIMEOUT": str(LINGER_S),
    "TLS_LINGER_TIMEOUT": str(LINGER_S),
    "RUST_MIN_STACK": str(STACK_BYTES),
}


def prepare() -> None:
    """Set the environment, which Zenoh reads when a process opens its first session; what is set there stays."""
    for name, value in ENVIRONMENT.items():
        os.environ.setdefault(name, value)
