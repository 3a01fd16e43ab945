"""Serves metrics to Prometheus from a separate process that only listens, so that no loop waits for a scrape."""

import time
from collections.abc import Callable, Iterable, Mapping
from contextlib import ExitStack
from typing import Protocol, TypeVar

from prometheus_client import CollectorRegistry, start_http_server
from prometheus_client.core import CounterMetricFamily, GaugeMetricFamily, Metric
from prometheus_client.registry import Collector

from common.errors import TransportError
from common.link.channel_feeds import ChannelFeeds
from common.link.channels import ANY, Channel
from common.link.config import ON_THIS_HOST, LinkSecurity
from common.link.endpoints import from_this_host
from common.link.port_holders import why_not_bound
from common.link.transport import open_link
from common.messages.base import Message
from common.process.service import StopFlag, be_nice

M = TypeVar("M", bound=Message)
Message_contra = TypeVar("Message_contra", bound=Message, contravariant=True)

NICE = 10
BEAT_S = 0.2
SCRAPE_S = 10.0  # a request that takes longer is no scrape: its thread ends


class MetricsSource(Protocol[Message_contra]):
    """Metrics derived from the messages of one channel."""

    def observe(self, message: Message_contra, now_ns: int) -> None:
        """Take a message that arrived at this time."""

    def families(self, now_ns: int) -> Iterable[Metric]:
        """All metrics at this time."""


def gauge(name: str, meaning: str, value: float) -> GaugeMetricFamily:
    """A metric without labels that rises and falls."""
    return GaugeMetricFamily(name, meaning, value=value)


def lost_pictures(lost: Mapping[str, int]) -> CounterMetricFamily:
    """Build the metric of the pictures that each camera of a site has lost, by its name."""
    family = CounterMetricFamily("farhand_camera_lost_pictures", "Pictures that did not come whole", labels=["camera"])
    for camera, count in lost.items():
        family.add_metric([camera], count)
    return family


class AtScrape(Collector):
    """Collects the metrics at each scrape."""

    def __init__(self, figures: MetricsSource[M]) -> None:
        self._figures = figures

    def collect(self) -> Iterable[Metric]:
        """The current metrics."""
        return self._figures.families(time.monotonic_ns())


def run_metrics(
    port: int,
    endpoint: str,
    channel: Channel[M],
    cell: str,
    figures: MetricsSource[M],
    should_stop: StopFlag,
    beat: Callable[[], None],
    security: LinkSecurity = ON_THIS_HOST,
    *,
    operator: str = ANY,
) -> None:
    """Listen to a channel at an endpoint and serve its metrics on 127.0.0.1 until asked to stop."""
    be_nice(NICE)
    registry = CollectorRegistry()
    registry.register(AtScrape(figures))
    with ExitStack() as stack:
        feeds = ChannelFeeds()
        stack.callback(feeds.join)  # once the link is closed
        link = stack.enter_context(open_link(connect=(from_this_host(endpoint),), security=security))
        feeds.add(link.latest(channel, cell, operator=operator), figures.observe)
        try:
            server, _ = start_http_server(port, addr="127.0.0.1", registry=registry)
        except OSError as error:
            raise TransportError(f"metrics.port {port} cannot be served: {why_not_bound(error, port)}") from error
        server.RequestHandlerClass.timeout = SCRAPE_S  # type: ignore[attr-defined]  # its stub says callable
        beat()
        while not should_stop.wait(BEAT_S):
            beat()
        server.shutdown()
        server.server_close()
