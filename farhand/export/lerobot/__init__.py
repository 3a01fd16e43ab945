"""Recorded sessions as a LeRobot dataset, format v3.0."""
