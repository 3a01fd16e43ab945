"""The configured mapping from hand to tool: relative to both origins, or incremental from sample to sample; pure."""

import math

from common.geometry import Array
from common.mapping.relative_mapping import RelativeMapping
from common.messages.hand import HandArm
from remote_site.teleop.config import MappingConfig


class IncrementalMapping(RelativeMapping):
    """The tool's present position and the hand's motion since the last sample (ROBONAUT report, section 3, steps 2-5).

    Samples carry the hand's position, the sum of all displacements, so a lost sample loses no motion. But the distance
    that the arm had left when the next sample arrived is lost: the tool drifts. Rotation counts from the reference.
    """

    def engage(self, hand_in_operator: Array, operator_R_hand: Array | None, base_T_tool: Array) -> None:
        """Capture both origins; the next displacement counts from this hand."""
        super().engage(hand_in_operator, operator_R_hand, base_T_tool)
        self._hand = hand_in_operator.copy()

    def read(self, base_T_tool: Array) -> None:
        """Begin the next displacement where the tool was sent last: a reading may be wrong."""
        self._offset = base_T_tool[:3, 3] - self._gain @ self._hand

    def target(self, hand_in_operator: Array, operator_R_hand: Array | None) -> Array:
        """The target `base_T_tool` (4 x 4): where the tool was sent plus the hand's motion since the last sample."""
        self._hand = hand_in_operator.copy()
        return super().target(hand_in_operator, operator_R_hand)

    def reference(self, sample: HandArm, hand_R_followed: Array | None) -> None:
        """None: the next target depends on where the tool is when its sample comes."""


def make_mapping(config: MappingConfig) -> RelativeMapping:
    """The configured mapping."""
    return IncrementalMapping(config) if config.command == "incremental" else RelativeMapping(config)


def thesis_angles(wrist: Array, index: Array, thumb: Array) -> tuple[float, float, float]:
    """The hand's angles α, β, γ in rad about Z, Y and X (thesis section 4.2, figure 4.5), for display alone.

    α and β are the directions of the line from the wrist to the middle between the tips, projected onto XY and XZ;
    γ is the direction of the line from the thumb's to the index finger's tip, projected onto YZ.
    """
    ahead = 0.5 * (index + thumb) - wrist
    across = index - thumb
    alpha = math.atan2(ahead[1], ahead[0])
    beta = math.atan2(ahead[2], ahead[0])
    gamma = math.atan2(across[2], across[1])
    return alpha, beta, gamma
