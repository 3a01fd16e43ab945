"""What an import chooses for an arm: start posture, workspace, limits, cell."""
