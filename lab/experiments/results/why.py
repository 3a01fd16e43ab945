"""Why one of the thesis's series failed, and what limits placing: what the experiment "causes" says, in words."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from lab.experiments.placing.causes import CAUSES
from lab.experiments.placing.series import FREE, ROLL_FIXED

TITLE = "Why a series failed"
HEAD = (
    "altered",
    "x, mm",
    "y, mm",
    "angle, deg",
    "placed",
    "time, s",
    "x, mm",
    "y, mm",
    "angle, deg",
    "placed",
    "time, s",
)
WORDS = {
    "as_it_is": "nothing",
    "exact_tracker": "exact tracker",
    "exact_sight": "exact sight",
    "exact_hand": "exact hand",
    "unseen_turn": "the block's turn unseen",
    "thesis_fingers": "the thesis's fingers",
    "thesis_fingers_unseen_turn": "the thesis's fingers, and the turn unseen",
    "thesis_rate": "the thesis's rate",
}

Figures = Mapping[str, Any]  # of report.json


def in_words(causes: Figures) -> Iterator[str]:
    """The paragraphs, with the figures of the experiment's report."""
    free, fixed = causes[FREE], causes[ROLL_FIXED]
    yield (
        "The thesis's tables 6.12 and 6.13 differ threefold: 11.6 mm, 11.4 mm and 11 deg with the tool's roll fixed, "
        "33.7 mm, 29 mm and 30 deg with all rotations. It leaves open why, and suspects the robot's control of roll "
        "(section 7.2.3). Its three angles are 28, 33 and 29 deg. Here one part of Farhand is altered at a time."
    )
    yield (
        "The mapping, which is the thesis's (section 4.2), costs little: where the hand is exact, and tracker, mapping "
        f"and arm are as ever, the block is left {_left(free['exact_hand'])} off with all rotations. With "
        f"nothing altered it is {_left(free['as_it_is'])}."
    )
    yield (
        f"Index and thumb as far off as the thesis measured them make it {_left(free['thesis_fingers'])} with all "
        f"rotations, and {_left(fixed['thesis_fingers'])} with the roll fixed, for an operator who sees how the block "
        "is turned and corrects it. One who does not see it, as in 2004 when the block hid the target from the "
        f"gripper's camera, leaves the block {_left(free['unseen_turn'])} off if the fingers are tracked as Farhand "
        f"tracks them, and {_left(free['thesis_fingers_unseen_turn'])} if both come together; with the roll fixed "
        f"{_left(fixed['thesis_fingers_unseen_turn'])}."
    )
    rate, ours = fixed["thesis_rate"], fixed["as_it_is"]
    yield (
        "At the thesis's rate of five pictures a second with the mean of nine, a trial with the roll fixed takes "
        f"{rate['time_s']['median']:.0f} s instead of {ours['time_s']['median']:.0f} s, and leaves the block "
        f"{_left(rate)} off."
    )


def rows(causes: Figures) -> Sequence[Sequence[str]]:
    """The table below: with the roll fixed on the left, with all rotations on the right."""
    return [(WORDS[name], *_cells(causes[ROLL_FIXED][name]), *_cells(causes[FREE][name])) for name in CAUSES]


def _cells(of: Figures) -> Sequence[str]:
    errors = (f"{of[name]['median']:.1f}" for name in ("x_mm", "y_mm", "angle_deg"))
    return *errors, f"{of['placed']} of {of['trials']}", f"{of['time_s']['median']:.0f}"


def _left(of: Figures) -> str:
    x, y, angle = (of[name]["median"] for name in ("x_mm", "y_mm", "angle_deg"))
    return f"{x:.1f} mm, {y:.1f} mm and {angle:.1f} deg"
