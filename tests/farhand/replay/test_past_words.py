"""A replay tells what was so, and nobody what to do: over every sentence that a state can have."""

import re

import msgspec
import pytest

from common.messages.robot import Readiness, SessionState
from farhand.replay.past_words import past_state, past_words
from local_site.tracking.foreground.reasons import ForegroundReason
from local_site.tracking.monocular.estimator import Refusal
from local_site.tracking.tracker import TrackingReason
from remote_site.drivers.faults import APART, STILL_MOVING, STOPPED
from remote_site.reasons import Code
from remote_site.session.hand_link_verdict import CURES
from tests.browser import scene

TRACKED = [str(reason) for reason in (*TrackingReason, *ForegroundReason, *Refusal)]
FAULTS = [fault.sentence for fault in (STOPPED, STILL_MOVING, APART)]
SENTENCES = [code.sentence for code in Code] + TRACKED + FAULTS + list(CURES.values())
TOLD_TO_DO = re.compile(
    r"(^|[:;.] )(activate|bring|check|engage|farhand|hold|keep|let go|open|press|print|reset it|start|take)\b|Cure"
)


@pytest.mark.parametrize("sentence", SENTENCES)
def test_nobody_is_told_what_to_do(sentence: str) -> None:
    assert TOLD_TO_DO.search(past_words(sentence)) is None


@pytest.mark.parametrize(
    ("said", "told"),
    [
        ("the arm follows the hand", "the arm follows the hand"),
        ("disengaged, the hand is lost; engage again to continue", "disengaged, the hand is lost"),
        ("stopped by anna; reset it, then engage", "stopped by anna"),
        ("reset; engage to continue", "reset"),
        ("ready: waiting to be engaged", "ready: waiting to be engaged"),
        (
            "let go of the key first, then press it: an engagement that has ended never resumes by itself",
            "an engagement that has ended never resumes by itself",
        ),
        ("a link of 3.5 Mbit/s is narrow. Cure: a wider link, or lower video.fps", "a link of 3.5 Mbit/s is narrow"),
        (
            "the operator's page is silent: open it and take the controls; to operate so, release the lease",
            "the operator's page is silent",
        ),
        ("hold the key", ""),
    ],
)
def test_what_was_so_stays(said: str, told: str) -> None:
    assert past_words(said) == told


def test_every_code_still_says_something() -> None:
    assert [code for code in Code if not past_words(code.sentence)] == []


def test_a_state_has_words_even_where_it_only_told_what_to_do() -> None:
    said = scene.state(SessionState.DISENGAGED, "let_go_first", "let go of the key first")
    said = msgspec.structs.replace(said, readiness=Readiness(False, "not_held", "the arm rests; hold the key", True))
    told = past_state(said)
    assert (told.reason, told.readiness.reason) == ("let go first", "the arm rests")
    assert told.readiness.code == "not_held"
    assert told.hand_link is None
