"""Experiments after the thesis: each runs by name and leaves a folder with report, plots and data."""
