"""Replay of what was recorded."""
