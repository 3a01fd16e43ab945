"""Metrics without labels for Prometheus."""

from prometheus_client.core import GaugeMetricFamily


def gauge(name: str, meaning: str, value: float) -> GaugeMetricFamily:
    """A metric that rises and falls."""
    return GaugeMetricFamily(name, meaning, value=value)
