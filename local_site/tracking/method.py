"""The trackers by name."""

from typing import Literal

Method = Literal["silhouette", "markers", "monocular"]
