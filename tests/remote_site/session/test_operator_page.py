"""What the operator has set: kept under its lease, replaced only by what is newer, and whose page is silent."""

import pytest

from common.messages.hand import Intent, Locks, OperatorSettings
from remote_site.session.operator_page import OperatorPage

AS_GRANTED, OTHER_LEASE = OperatorSettings(lease=41), OperatorSettings(lease=42, revision=4)
LOCKED = OperatorSettings(lease=41, revision=3, scale=0.5, locks=Locks(z=True))


def page_with(*reported: OperatorSettings | None) -> OperatorPage:
    """A page under lease 41 that has reported these settings."""
    page = OperatorPage()
    page.begin(41)
    for settings in reported:
        page.see(Intent(settings=settings))
    return page


def test_a_lease_begins_with_the_defaults_under_its_number() -> None:
    assert page_with().settings == OperatorSettings(lease=41)


def test_what_is_newer_is_taken() -> None:
    later = OperatorSettings(lease=41, revision=9)
    assert page_with(LOCKED).settings == LOCKED
    assert page_with(LOCKED, later).settings == later


@pytest.mark.parametrize(
    "reported",
    [
        None,
        OperatorSettings(),
        AS_GRANTED,
        OperatorSettings(lease=41, revision=2),
        OperatorSettings(lease=41, revision=3),
        OperatorSettings(lease=40, revision=4),
        OTHER_LEASE,
    ],
)
def test_defaults_older_ones_and_those_of_another_lease_overwrite_nothing(reported: OperatorSettings | None) -> None:
    assert page_with(LOCKED, reported).settings == LOCKED


def test_silence_keeps_the_settings() -> None:
    page = page_with(LOCKED)
    page.see(None)
    assert page.settings == LOCKED


def test_a_renewed_lease_keeps_them() -> None:
    page = page_with(LOCKED)
    page.see(None)
    page.begin(41)
    assert page.settings == LOCKED
    assert page.silent


def test_another_lease_begins_with_the_defaults_and_without_a_page() -> None:
    page = page_with(LOCKED)
    page.see(None)
    page.begin(42)
    assert page.settings == OperatorSettings(lease=42)
    assert not page.silent


def test_before_the_first_lease_no_page_is_silent() -> None:
    page = OperatorPage()
    page.see(None)
    assert not page.silent


def test_only_a_page_that_has_reported_can_be_silent() -> None:
    page = page_with()
    page.see(None)
    assert not page.silent
    page.see(Intent())
    assert not page.silent
    page.see(None)
    assert page.silent
    page.see(Intent())
    assert not page.silent
