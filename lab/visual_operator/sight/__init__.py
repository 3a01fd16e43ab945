"""How the visual operator sees: colours, outlines and edges in calibrated views, and the poses of what it knows."""
