"""Choices that an import makes for an arm: start posture, workspace, limits, cell."""
