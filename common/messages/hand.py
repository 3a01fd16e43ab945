"""The hand sample: points with covariances, clock offset, the operator's intent and settings; frozen structs."""

from enum import StrEnum
from typing import Annotated

import msgspec

from common.messages.base import Count, Covariance, Difference, Message, Name, Text, Vector3


class TrackingStatus(StrEnum):
    """The reliability of a hand sample."""

    INITIALISING = "initialising"
    TRACKED = "tracked"
    DEGRADED = "degraded"
    LOST = "lost"


FOUND = (TrackingStatus.TRACKED, TrackingStatus.DEGRADED)  # with points that may be used


class HandPoint(StrEnum):
    """Which point of the hand the tool copies; only the tracker of one camera measures the palm."""

    WRIST = "wrist"
    PALM = "palm"


class PointCovariances(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """The covariance xx, xy, xz, yy, yz, zz of each point, m² in the operator frame, None where unknown.

    It travels in six bytes (`wire_form.py`).
    """

    elbow: Covariance | None = None
    wrist: Covariance | None = None
    index: Covariance | None = None
    thumb: Covariance | None = None
    palm: Covariance | None = None


class Locks(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Motions that the operator has locked: along the base's axes, and about the tool's."""

    x: bool = False
    y: bool = False
    z: bool = False
    roll: bool = False
    pitch: bool = False
    yaw: bool = False


class OperatorSettings(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """The operator's settings under one lease; every lease begins with these defaults.

    `lease` is its number, 0 without one. `revision` rises by one with each change, and when the operator takes new
    origins: settings only ever replace those of a lower revision. The scales multiply what the remote site has
    configured.
    """

    lease: Count = 0
    revision: Count = 0
    scale: Annotated[float, msgspec.Meta(ge=0.01, le=5)] = 1.0
    rotation_scale: Annotated[float, msgspec.Meta(ge=0, le=2)] = 1.0
    locks: Locks = Locks()

    def followed_by(self, new: "OperatorSettings | None") -> "OperatorSettings":
        """The settings in force after `new` came, if any: only a higher revision under the same lease replaces them."""
        return new if new is not None and new.lease == self.lease and new.revision > self.revision else self


class ClutchKey(StrEnum):
    """The key, button or pedal of the clutch; `unseen` was down, and nobody can say whether it was let go."""

    UP = "up"
    DOWN = "down"
    UNSEEN = "unseen"


class Intent(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """The report of the operator's page or pedal: whether the hold-to-run key or pedal is down, and the settings.

    `settings` is None from a sender that does not know those in force, or where they are in force already. `assist` is
    the target that was offered when the key of fine adjustment went down, None while it is not held. While `clutch` is
    not up the arm holds, and the operator moves the hand alone.
    """

    hold: bool = False
    settings: OperatorSettings | None = None
    assist: Name | None = None
    clutch: ClutchKey = ClutchKey.UP


class OperatorIntent(Message, frozen=True):
    """The intent as a console or pedal sends it to the local site on its own host, at 20 Hz or more.

    `session` is a random number chosen at each start of the sender: of several the local site obeys one at a time.
    `intent` is None when the operator's page has fallen silent; nothing more is sent until one reports again.
    """

    session: Count
    sent_ns: Count
    intent: Intent | None


class ClockSync(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """The remote site's clock minus the local site's, as the local site measured it over the control session, ns.

    `measured_ns` is when it was confirmed last, by the remote site's clock, which so knows how long ago that was, and
    `remote_ahead_ns` by how much steady time was ahead of that clock then: so the remote site knows what its clock was
    slewed by since. None from a sender that does not tell.
    """

    remote_minus_local_ns: Difference
    uncertainty_ns: Count
    measured_ns: Count
    remote_ahead_ns: Difference | None = None


class HandArm(Message, frozen=True):
    """One tracked instant of the operator's arm.

    Points are absolute in the operator frame (the calibration plate's), m, None where they could not be measured; the
    palm is a point of the hand as a rigid extension of the forearm, from the tracker of one camera alone.
    `covariance` is of the single measurement, before smoothing; None from a sender that does not know it.
    `session` is a random number chosen at each start of the local site, `seq` rises by one each sample,
    `gripper_toggles` counts the openings of the hand since the session began. `lease` is the number of this operator's
    lease, 0 without one; `clock` is None while the offset is not known; `intent` is None while no page reports one.
    `read_ns` is when its pictures were read from the cameras, `sent_ns` when it was handed to the network, both by the
    local site's clock; None from a sender that does not tell, `read_ns` also without pictures.
    """

    session: Count
    seq: Count
    capture_ns: Count
    elbow: Vector3 | None
    wrist: Vector3 | None
    index: Vector3 | None
    thumb: Vector3 | None
    status: TrackingStatus
    reason: Text
    thumb_inferred: bool
    hand_open: bool
    gripper_toggles: Count
    palm: Vector3 | None = None
    covariance: PointCovariances | None = None
    lease: Count = 0
    clock: ClockSync | None = None
    intent: Intent | None = None
    read_ns: Count | None = None
    sent_ns: Count | None = None
