"""Experiments that reproduce tables and figures of the thesis on markerless stereo hand-arm tracking (2004)."""
