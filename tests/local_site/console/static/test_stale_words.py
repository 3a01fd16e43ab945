"""Which pictures are not live, and since when, as the next step says it first."""

from typing import Any

import pytest

from tests.local_site.console.static.page_script import run

WORDS = 'return (await load("stale_words")).staleWords(v);'


def view(name: str, mark: str = "live", age_ms: float | None = 40.0, *, useful: bool | None = None) -> dict[str, Any]:
    is_useful = age_ms is not None and age_ms <= 1000.0 and mark in ("live", "old", "slow")
    return {"name": name, "mark": mark, "ageMs": age_ms, "isUseful": is_useful if useful is None else useful}


SIDE, TOP = view("side"), view("top")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("views", "words"),
    [
        ([], ""),
        ([SIDE, TOP], ""),
        ([view("side", "slow", 200.0), TOP], ""),
        ([view("side", "old", 3200.0), TOP], "Look out: side is 3 s old."),
        ([view("side", "old", 400.0), TOP], "Look out: side comes late."),
        (
            [view("side", "frozen", 5200.0), view("top", "none", None), view("tool")],
            "Look out: side is frozen, 5 s old, top has no picture.",
        ),
        ([view("side", "old", 400.0), view("top", "old", 400.0)], "All pictures of the cell come late."),
        (
            [view("side", "old", 4100.0), view("top", "old", 200_000.0)],
            "No live picture of the cell. The newest is 4 s old.",
        ),
        ([view("side", "none", None)], "No live picture of the cell."),
        ([*(view(name, "old", 3000.0) for name in "abcd"), SIDE], "Look out: a is 3 s old, b is 3 s old, 2 more."),
        ([view("side", "dark", 200.0), TOP], "Look out: side is dark, less than 1 s old."),
        ([view("side", "old", 150_000.0), TOP], "Look out: side is 2 min old."),
    ],
)
def test_the_words(views: list[dict[str, Any]], words: str) -> None:
    assert run(WORDS, *views) == words
