"""The delay between the hand's motion and its picture, and the scale that is suggested for it; pure."""

MILD_MS = 200.0  # up to here a delay's effect on manipulation is mild (Xu et al., Surg Endosc 28, 2014)
STEP = 0.05  # of the page's control
LEAST = 0.1


def loop_delay_ms(picture_ms: float | None, round_trip_ms: float | None) -> float | None:
    """What link and pictures add between hand and eye: the way there, and the picture's age when it is painted.

    The age contains the way back; the way there is half the round trip. None while one of them is not known.
    """
    return None if picture_ms is None or round_trip_ms is None else picture_ms + 0.5 * round_trip_ms


def suggested_scale(loop_ms: float | None) -> float:
    """The operator's scale at which the tool goes no further unseen than at full scale after the longest mild delay.

    During the delay the tool goes scale * speed of the hand * delay before the operator sees any of it (Ferrell 1965):
    the scale falls as the delay's inverse. In steps of the page's control; 1 while the delay is mild or not known.
    """
    if loop_ms is None or loop_ms <= MILD_MS:
        return 1.0
    return round(max(LEAST, STEP * round(MILD_MS / loop_ms / STEP)), 2)
