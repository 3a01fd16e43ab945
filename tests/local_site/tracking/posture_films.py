"""Films of a hand that shows one posture for a moment, between two times of the U that it is held in otherwise."""

from dataclasses import dataclass, replace

import numpy as np

from common.geometry import Array, rotation_from_vector
from local_site.simulation.body import ArmBody, ArmTruth, BodyPose
from local_site.simulation.config import BodyConfig, MotionConfig, PictureConfig
from local_site.simulation.hand import FIST, FLAT, POINTING, SPREAD, U_SHAPE, FingerPosture, unit
from local_site.simulation.motion import Motion, minimum_jerk
from local_site.simulation.rendering import Renderer
from tests.local_site.tracking.rendered_arm import PAIR, PERIOD_S, STEREO, Sequence

# 0.2 s for a change of posture, as the simulated operator's, and more than `GestureConfig.hold_ms` for each
U_FRAMES, CHANGE_FRAMES, SHOWN_FRAMES, U_AGAIN_FRAMES = 16, 6, 15, 8
FRAMES = U_FRAMES + SHOWN_FRAMES + U_AGAIN_FRAMES + 2 * CHANGE_FRAMES
BODY, STILL = BodyConfig(), MotionConfig(name="hold")


def _with(posture: FingerPosture, fan_deg: tuple[float, ...] = (), thumb: FingerPosture | None = None) -> FingerPosture:
    """The posture with its fingers fanned by other angles, and the thumb of another."""
    forward, curl, bend_deg = posture.forward.copy(), posture.curl.copy(), posture.bend_deg.copy()
    if fan_deg:
        angles = np.radians(fan_deg)
        forward[:4] = np.column_stack([np.cos(angles), np.sin(angles), np.zeros(4)])
    if thumb is not None:
        forward[4], curl[4], bend_deg[4] = thumb.forward[4], thumb.curl[4], thumb.bend_deg[4]
    return FingerPosture(forward, curl, bend_deg)


TOGETHER = (-3.0, 0.0, 4.0, 9.0)  # as in the U: the fingers lie side by side
FLAT_TOGETHER = _with(FLAT, TOGETHER)
TUCKED = _with(FLAT, TOGETHER, thumb=FIST)
HALF_OPEN = FingerPosture(
    U_SHAPE.forward, U_SHAPE.curl, np.vstack([0.5 * (U_SHAPE.bend_deg[:4] + FLAT.bend_deg[:4]), U_SHAPE.bend_deg[4:]])
)
PINCH = FingerPosture(
    U_SHAPE.forward, U_SHAPE.curl, np.vstack([[[30, 65, 95]], 1.6 * U_SHAPE.bend_deg[1:4], [[0, 38, 62]]])
)
STRETCHED_U = _with(FLAT, TOGETHER, thumb=U_SHAPE)


@dataclass(frozen=True)
class Shown:
    """A posture, and how the hand is rolled about its own length meanwhile, deg: 80 shows the palm to the cameras."""

    posture: FingerPosture
    roll_deg: float = 0.0
    swing_deg: float = 0.0


POSTURES = {
    "the U": Shown(U_SHAPE, 40.0),
    "a fist": Shown(FIST, 30.0),
    "a pointing index": Shown(POINTING, 30.0),
    "flat, palm to the cameras": Shown(FLAT_TOGETHER, 80.0),
    "flat, edge to the cameras": Shown(FLAT_TOGETHER, -10.0),
    "flat, turning": Shown(FLAT_TOGETHER, 35.0, 45.0),
    "flat, the thumb tucked in": Shown(TUCKED, 60.0),
    "stretched, the thumb opposed": Shown(STRETCHED_U, 30.0),
    "half open": Shown(HALF_OPEN, 30.0),
    "a pinch": Shown(PINCH, 20.0),
}
SPREADS = {
    "spread": Shown(SPREAD, 45.0),
    "spread, palm to the cameras": Shown(SPREAD, 80.0),
}


def film(shown: Shown) -> Sequence:
    """What two cameras see of it, and the truth."""
    motion = Motion(STILL, BODY, 1)
    renderers = [Renderer(camera, ArmBody(BODY).parts, STEREO, PictureConfig(), 1 + k) for k, camera in enumerate(PAIR)]
    solids, truths = [], list[ArmTruth]()
    for k in range(FRAMES):
        body, pose = posed(motion, shown, k)
        solids.append(body.solid(pose))
        truths.append(body.truth(pose))
    return Sequence(
        projections=tuple(camera.projection for camera in PAIR),
        times_s=tuple(k * PERIOD_S for k in range(FRAMES)),
        pictures=tuple(tuple(renderer.render([solid]) for renderer in renderers) for solid in solids),
        truths=tuple(truths),
    )


def posed(motion: Motion, shown: Shown, k: int) -> tuple[ArmBody, BodyPose]:
    """The arm at the k-th instant."""
    begins = U_FRAMES + CHANGE_FRAMES
    part = minimum_jerk((k - U_FRAMES) / CHANGE_FRAMES) - minimum_jerk((k - begins - SHOWN_FRAMES) / CHANGE_FRAMES)
    swing = shown.swing_deg * np.sin(2 * np.pi * (k - begins) / SHOWN_FRAMES) if shown.swing_deg else 0.0
    pose = motion.pose(k * PERIOD_S)
    roll = rotation_from_vector(np.array([np.radians(part * (shown.roll_deg + swing)), 0.0, 0.0]))
    return ArmBody(BODY, _between(U_SHAPE, shown.posture, part)), replace(
        pose, operator_R_hand=pose.operator_R_hand @ roll
    )


def _between(a: FingerPosture, b: FingerPosture, part: float) -> FingerPosture:
    def blend(one: Array, other: Array) -> Array:
        return (1.0 - part) * one + part * other

    forward = unit(blend(a.forward, b.forward))
    curl = blend(a.curl, b.curl)
    curl = unit(curl - np.sum(curl * forward, axis=1, keepdims=True) * forward)
    return FingerPosture(forward, curl, blend(a.bend_deg, b.bend_deg))
