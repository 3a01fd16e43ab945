"""Stands in for LeRobot, which is not installed here: its classes for teleoperators by name and type, nothing else."""
