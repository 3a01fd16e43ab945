"""The process that serves viewers: it may die or be slow, the site goes on without it."""

import structlog

from common.link.config import ViewersConfig
from common.link.credentials import CertificateValidity
from common.link.viewers import Site, open_passage
from common.process.children import Heartbeat
from common.process.service import StopFlag, be_nice, bound_memory

NICE = 10
MOST_MEMORY_BYTES = 2 << 30  # Zenoh bounds nothing that a neighbour declares
BEAT_S = 0.1
BEATS_PER_VALIDITY = 10


def run_viewers(viewers: ViewersConfig, table: str, site: Site, should_stop: StopFlag, heartbeat: Heartbeat) -> None:
    """Serve viewers until asked to stop; TransportError when that cannot be, or once their certificate has expired.

    `table` is the configuration's that names their certificates.
    """
    be_nice(NICE)
    bound_memory(MOST_MEMORY_BYTES)
    validity, beats = CertificateValidity(viewers.tls, table), 0
    with open_passage(viewers, table, site) as passage:
        structlog.get_logger().info("viewers may connect", listen=viewers.listen)
        while not should_stop.wait(BEAT_S):
            passage.follow()
            beats += 1
            if beats % BEATS_PER_VALIDITY == 0:
                validity.check()
            heartbeat.beat()
