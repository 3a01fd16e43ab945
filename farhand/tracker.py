"""All that an author of a tracker needs of Farhand; docs/writing-a-tracker.md shows how, and promises nothing beyond.

A `TrackerKind`, the entry point of the group `farhand.trackers`, makes a `Tracker` from a `TrackerHost`: `Views` of an
instant in, an `ArmEstimate` out. `check_options` checks the tracker's own options.
"""

from common.cameras.camera import Frame, Image
from common.errors import ConfigError, NotInstalledError
from common.messages.hand import TrackingStatus
from local_site.calibration.rig import CameraCalibration, Rig
from local_site.calibration.triangulation import triangulate
from local_site.tracking.registry import Option, Scene, TrackerHost, TrackerKind, check_options
from local_site.tracking.tracker import ArmEstimate, Overlay, Tracker, TrackingReason, View, Views

__all__ = [
    "ArmEstimate",
    "CameraCalibration",
    "ConfigError",
    "Frame",
    "Image",
    "NotInstalledError",
    "Option",
    "Overlay",
    "Rig",
    "Scene",
    "Tracker",
    "TrackerHost",
    "TrackerKind",
    "TrackingReason",
    "TrackingStatus",
    "View",
    "Views",
    "check_options",
    "triangulate",
]
