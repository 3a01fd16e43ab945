"""Fine adjustment by the robot: where markers are, which pose is offered, and how the tool is led there."""
