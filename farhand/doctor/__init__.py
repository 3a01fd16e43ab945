"""Checks a machine and a configuration, and states the cures: facts are probed, findings are derived from facts."""
