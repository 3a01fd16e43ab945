"""Pictures of what cameras are calibrated with, as a simulated camera sees it."""
