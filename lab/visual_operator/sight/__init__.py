"""Sight of the visual operator: colours, outlines and edges in calibrated views, and the poses of what it knows."""
