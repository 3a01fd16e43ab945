"""Drawn arms: bodies of every build, poses that a human arm has, and their surfaces seen by a camera."""
