"""Sentences that say what is wrong with which joint: names, and positions in rad as expected and as read; pure."""

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from common.geometry import Array

SEEN_RAD = 0.02  # less may be noise
MIRRORED = 4.0  # times nearer to the mirror image than to what was commanded


def positions(names: Sequence[str], q: Array) -> str:
    """Every joint's name and position (n,) in rad."""
    return ", ".join(f"{name} {value:.3f}" for name, value in zip(names, q, strict=True)) + " rad"


def moved(names: Sequence[str], before: Array, after: Array) -> str:
    """The joint that has moved farthest between two postures (n,) in rad."""
    k = int(np.abs(after - before).argmax())
    return f"{names[k]} from {before[k]:.3f} to {after[k]:.3f} rad"


def wrong_way(names: Sequence[str], begin: Array, goal: Array, measured: Array) -> str:
    """Say which joints move as with a wrong sign, all (n,) in rad; "" without one.

    They have gone away from their goal, to its mirror image at where they began or at zero.
    """
    farther = np.abs(measured - goal) > np.abs(begin - goal) + SEEN_RAD
    opposite = (measured - begin) * (goal - begin) < 0
    wrong = np.flatnonzero(farther & (opposite | mirrored(goal, measured)))
    if not len(wrong):
        return ""
    k, others = int(wrong[0]), ", ".join(names[int(each)] for each in wrong[1:])
    went = f"{names[k]} went from {begin[k]:.3f} to {measured[k]:.3f} rad where it was commanded to {goal[k]:.3f} rad"
    return f"{went}, as with a wrong sign{f'; so did {others}' if others else ''}"


def unlike_in_sign(names: Sequence[str], given: Array, read: Array) -> str:
    """Say which joints are read at the mirror image of where they were activated, both (n,) in rad; "" without one."""
    wrong = ", ".join(names[int(k)] for k in np.flatnonzero(mirrored(given, read)))
    return f"activate and read differ in the sign of {wrong}" if wrong else ""


def mirrored(expected: Array, measured: Array) -> npt.NDArray[np.bool_]:
    """Return which joints (n,) are much nearer to the mirror image, at zero, of where they are expected."""
    off = np.abs(measured - expected)
    near: npt.NDArray[np.bool_] = (off > SEEN_RAD) & (off > MIRRORED * np.abs(measured + expected))
    return near
