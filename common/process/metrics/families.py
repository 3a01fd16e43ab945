"""A figure without labels, as Prometheus is told of it."""

from prometheus_client.core import GaugeMetricFamily


def gauge(name: str, meaning: str, value: float) -> GaugeMetricFamily:
    """A figure that rises and falls."""
    return GaugeMetricFamily(name, meaning, value=value)
