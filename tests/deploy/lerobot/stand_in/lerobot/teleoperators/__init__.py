"""LeRobot's teleoperators."""
