"""From the hand's motion to the tool's target, as the remote site computes it and the console repeats it; pure."""
