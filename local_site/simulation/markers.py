"""The simulated operator's dark glove and its three bright balls: on the wrist's radial side, on index and thumb."""

from dataclasses import replace

import numpy as np

from common.geometry import Array
from local_site.simulation.body import FOREARM_AT, ArmBody, ArmTruth, BodyPose, Part, Solid

RADIUS_M = 0.012
# Half the width of a wrist: the thesis's markers sit on the radial side of it (section 5.2).
WRIST_IN_HAND = np.array([0.0, 0.033, 0.0])


class MarkedArm:
    """An arm that wears markers; those of the fingers are caps about the last joint, so that they show from all sides.

    The truth for wrist, index and thumb is the centres of the markers.
    """

    def __init__(self, body: ArmBody) -> None:
        self._body = body
        by_name = {part.name: part for part in body.parts}
        self._tips = [int(by_name[name].balls[-1]) for name in ("index", "thumb")]
        wrist = 2 * len(FOREARM_AT) - 1
        self.parts = body.parts + tuple(
            Part(f"{name} marker", (np.array([body.ball_count + 1 + k]),), worn_on=(limb, ball))
            for k, (name, limb, ball) in enumerate(
                [
                    ("wrist", by_name["forearm"], wrist),
                    ("index", by_name["index"], self._tips[0]),
                    ("thumb", by_name["thumb"], self._tips[1]),
                ]
            )
        )

    def solid(self, pose: BodyPose) -> Solid:
        """The skin of the whole arm in this pose, with its markers."""
        skin = self._body.solid(pose)
        return replace(skin, markers=self._centres(pose, skin), marker_radius=RADIUS_M)

    def truth(self, pose: BodyPose) -> ArmTruth:
        """The elbow, and the centres of the markers."""
        wrist, index, thumb = self._centres(pose, self._body.solid(pose))
        return replace(self._body.truth(pose), wrist=wrist, index=index, thumb=thumb)

    def _centres(self, pose: BodyPose, skin: Solid) -> Array:
        wrist = pose.wrist + pose.operator_R_hand @ WRIST_IN_HAND
        return np.vstack([wrist, skin.centres[self._tips]])
