"""What LeRobot's parts share."""
