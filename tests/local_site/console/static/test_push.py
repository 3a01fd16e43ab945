"""The way back from a limit in the operator's words, of the same push as the arrow."""

import pytest

from tests.local_site.console.static.page_script import run

WORDS = """
  const { WayBack } = await load("push");
  const way = new WayBack();
  return v.map((wanted) => way.words({ measured: { position: [0.4, 0, 0.9] }, wanted }));
"""
NOBODY = 'const { WayBack } = await load("push"); return new WayBack().words({ measured: null, wanted: [1, 0, 0] });'


@pytest.mark.parametrize(
    ("push", "back"),
    [
        ((0.05, 0.0, 0.0), "towards you"),
        ((-0.05, 0.0, 0.0), "away from you"),
        ((0.0, 0.05, 0.01), "to the right"),  # the operator's left is the robot's, +y
        ((0.0, -0.05, 0.0), "to the left"),
        ((0.01, 0.0, 0.05), "down"),
        ((0.0, 0.0, -0.05), "up"),
        ((0.03, 0.0, 0.05), "towards you and down"),
        ((0.03, 0.03, -0.03), "towards you and to the right and up"),
        ((0.001, 0.0, 0.0), ""),
    ],
)
def test_the_way_back_is_against_the_push(push: tuple[float, float, float], back: str) -> None:
    x, y, z = push
    assert run(WORDS, (0.4 + x, y, 0.9 + z)) == [back]


def test_it_is_not_said_where_hand_or_tool_is_not_known() -> None:
    assert run(WORDS, None) == [""]
    assert run(NOBODY) == ""


def test_a_direction_that_was_named_stays_until_it_hardly_counts() -> None:
    slanted = (0.4 + 0.9, 0.0, 0.9 + 0.4359)  # 0.44 of the push is up
    steep, flat = (0.4 + 0.8, 0.0, 0.9 + 0.6), (0.4 + 0.98, 0.0, 0.9 + 0.2)
    assert run(WORDS, slanted) == ["towards you"]
    assert run(WORDS, steep, slanted, flat, slanted) == [*["towards you and down"] * 2, *["towards you"] * 2]
