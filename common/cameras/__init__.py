"""Cameras: what a frame is, and the sources that both sites can open."""
