"""Why a silhouette that was found is not to be trusted."""

from enum import StrEnum


class ForegroundReason(StrEnum):
    """Why the arm's outline is not given: a sentence each, with the cure where there is one."""

    NOT_SEEN = "the hand is outside the picture"
    COVERED = "the forearm does not have the hand's colour: roll the sleeve up beyond the elbow"
    HAND_CUT = "the hand does not stand out from what is behind it: change the background or the light"
    NO_FOREARM = "no forearm stands out next to the hand: change the background or the light"
    LEAKS = "the arm and what is behind it have the same colour: change the background or the light"
    NO_COLOUR = (
        "the picture is grey, but in a room the arm is told by its colour: take cameras that give colour, or hang dark "
        "cloth behind the arm"
    )
    JUMPED = "the arm's outline has changed too much at once"
