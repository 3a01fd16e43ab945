"""Metrics of a running site for Prometheus."""
