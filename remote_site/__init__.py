"""The robot's side: control, safety, drivers, video, and a simulated cell."""
