"""Farhand's hand as a LeRobot teleoperator; LeRobot finds this package by its name, and the type `farhand` in it."""

from lerobot_teleoperator_farhand.config import FarhandTeleopConfig
from lerobot_teleoperator_farhand.teleop import FarhandTeleop

__all__ = ["FarhandTeleop", "FarhandTeleopConfig"]
