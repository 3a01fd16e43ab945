"""Measures the link to the remote site by probes, and recommends the settings for it."""
