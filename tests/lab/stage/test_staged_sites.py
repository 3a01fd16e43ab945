"""The programs on a stage: awaited while all of them run, and ended by name or together."""

import sys

import pytest

from common.errors import ProcessError
from lab.stage.staged_sites import StagedSites
from lab.stage.waiting import until

LASTING = [sys.executable, "-c", "import time; time.sleep(60)"]
REFUSING = [sys.executable, "-c", "raise SystemExit('farhand: no camera')"]
TERMINATED = -15


def test_a_program_that_ends_meanwhile_ends_the_wait_with_its_reason():
    sites = StagedSites({})
    sites.start("local", REFUSING)
    with pytest.raises(ProcessError, match=r"the local process ended \(exit code 1\): no camera"):
        sites.wait("the hand", lambda: False, 30.0)
    sites.end()


def test_one_program_ends_alone_and_the_others_together():
    sites = StagedSites({})
    page, console = (sites.start(name, LASTING) for name in ("page", "console"))
    sites.end_named("page")
    assert (page.exit_code, console.exit_code) == (TERMINATED, None)
    assert sites.named("console") is console
    with pytest.raises(KeyError):
        sites.named("page")
    sites.end()
    assert console.exit_code == TERMINATED


def test_what_never_comes_is_named_with_what_is_told_of_it():
    with pytest.raises(ProcessError, match=r"^waited 0\.01 s in vain for a hand: it is lost$"):
        until(lambda: False, "a hand", 0.01, lambda: "it is lost")
