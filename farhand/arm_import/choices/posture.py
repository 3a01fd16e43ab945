"""A start posture: the tool before the arm, free to move all around, clear of limits, cell and itself; pure."""

import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from common.errors import ModelError
from common.geometry import Array, transform
from farhand.arm_import.choices.box import ReachedBox, choose_box
from farhand.arm_import.choices.reaching import WORST_CONDITION, PostureQuality, Reaching
from farhand.terminal import ShowProgress

Direction = Literal["down", "forward"]
DIRECTIONS: tuple[Direction, ...] = ("down", "forward")
# The tool's axes (columns) in the base's: z along the fingers; -x is up, or forward where the tool points down, so
# that a camera on the tool sees what is ahead above; y, along which fingers close, to the left.
BASE_R_TOOL: dict[Direction, Array] = {
    "down": np.array([[-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, -1.0]]),
    "forward": np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]]),
}
AHEAD, HIGH = (0.45, 0.55, 0.65), (0.30, 0.38, 0.46)  # of the reach, where the tool may begin
TRIED, SEEDS = 4000, 10  # postures, and how many of them a search begins from
TURN_M = 0.3
FINALISTS = 8
LEAST_M, CLEAR_M = 0.0115, 0.06  # from the cell and itself: less is not taken, more is no better
WOUND, WOUND_IF_FREE = 0.1, 1.0  # cost of turns from the middle of the ranges; of more axes than six, one is free
SIX = 6
APART_RAD = 0.5
NEARLY = 0.85
TURNED = 0.3  # cost of a tool that is turned about its own axis
HALF_TURN = np.diag([-1.0, -1.0, 1.0])
ROOM_RAD = 0.6  # to a joint's limit: more is no better
SCALES = (1.0, 0.75, 0.5, 0.35, 0.25)


@dataclass(frozen=True, slots=True, eq=False)
class Start:
    """A start posture (n,) in rad, where the tool points, and the box of all that it reaches from there.

    `turned` is whether the tool is turned half about its own axis; `scale` how much of the hand's motion fits before
    the arm.
    """

    q: Array
    points: Direction
    turned: bool
    scale: float
    box: ReachedBox
    quality: PostureQuality


def choose_start(reaching: Reaching, reach_m: float, points: Direction | None, show: ShowProgress) -> Start:
    """The best start posture of those with nearly the largest box; ModelError where there is none."""
    directions = DIRECTIONS if points is None else (points,)
    finalists = [(d, *found) for d in directions for found in _finalists(reaching, reach_m, d, show)]
    for scale in SCALES:
        boxes = []
        for finalist in finalists:
            boxes.append((*finalist, choose_box(reaching, finalist[-1], reach_m, scale)))
            show(f"boxes tried{_part(scale)}", len(boxes), len(finalists))
        found = [Start(q, d, turned, scale, box, reaching.quality(q)) for d, turned, q, box in boxes if box is not None]
        if found:
            enough = NEARLY * max(start.box.volume for start in found)
            return next(start for start in found if start.box.volume >= enough)
    raise ModelError(
        "no posture was found from which the tool moves freely before the arm, pointing down or forward, clear of the "
        "table at z = 0; where something carries the arm, begin at the link on which it stands, z upwards: --base LINK"
    )


def _part(scale: float) -> str:
    """Say for what part of the hand's motion it is, where it is not all."""
    return f" for {scale:g} of the hand's motion" if scale < 1.0 else ""


def _finalists(reaching: Reaching, reach_m: float, points: Direction, show: ShowProgress) -> list[tuple[bool, Array]]:
    """Find the best postures that differ from each other; each with whether the tool is turned."""
    chosen: list[tuple[bool, Array]] = []
    for _, turned, q in sorted(_candidates(reaching, reach_m, points, show), key=lambda found: found[0]):
        if all(np.abs(q - other).max() > APART_RAD for _, other in chosen):
            chosen.append((turned, q))
        if len(chosen) == FINALISTS:
            break
    return chosen


def _candidates(
    reaching: Reaching, reach_m: float, points: Direction, show: ShowProgress
) -> Iterator[tuple[float, bool, Array]]:
    """Postures with their costs, and whether the tool is turned in them."""
    seeds = np.array(list(reaching.postures(TRIED)))
    poses = np.array([reaching.model.forward(q) for q in seeds])
    places = list(itertools.product(AHEAD, HIGH, (False, True)))
    for tried, (ahead, high, turned) in enumerate(places, start=1):
        show(f"start postures tried, the tool {points}", tried, len(places))
        rotation = BASE_R_TOOL[points] @ (HALF_TURN if turned else np.eye(3))
        target = transform(rotation, np.array([ahead * reach_m, 0.0, high * reach_m]))
        for seed in seeds[_nearest(poses, target)]:
            q = reaching.towards(target, seed, reaching.middle if len(seed) > SIX else seed)
            if q is not None and (cost := _cost(reaching, q)) < math.inf:
                yield cost + TURNED * turned, turned, q


def _nearest(poses: Array, target: Array) -> NDArray[np.intp]:
    """The numbers of the poses (m x 4 x 4) nearest to a target, a turn of 1 rad counting as TURN_M."""
    away = np.linalg.norm(poses[:, :3, 3] - target[:3, 3], axis=1)
    cosines = (np.einsum("kij,ij->k", poses[:, :3, :3], target[:3, :3]) - 1.0) / 2.0
    return np.argsort(away + TURN_M * np.arccos(np.clip(cosines, -1.0, 1.0)))[:SEEDS]


def _cost(reaching: Reaching, q: Array) -> float:
    """Less is better: singular and wound up postures cost, and such that are close to something or to a limit."""
    quality = reaching.quality(q)
    if quality.distance_m < LEAST_M or quality.room_rad < ROOM_RAD / 4 or quality.condition > WORST_CONDITION:
        return math.inf
    close = max(0.0, CLEAR_M - quality.distance_m) / CLEAR_M
    short = max(0.0, ROOM_RAD - quality.room_rad) / ROOM_RAD
    wound = float(np.square((q - reaching.middle) / math.pi).sum())
    weight = WOUND_IF_FREE if len(q) > SIX else WOUND
    return math.log(quality.condition) + close + short + weight * wound
