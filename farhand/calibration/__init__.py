"""Calibration on the command line: points, plates, boards."""
