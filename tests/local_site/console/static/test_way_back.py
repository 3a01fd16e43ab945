"""The way back from a limit in the operator's words, against the push, as the arrow."""

import pytest

from tests.local_site.console.static.page_script import run

WORDS = """
  const { WayBack } = await load("way_back");
  const way = new WayBack();
  return v.map((wanted) => way.words({ measured: { position: [0.4, 0, 0.9] }, wanted }));
"""
NOBODY = """
  const { WayBack } = await load("way_back");
  return new WayBack().words({ measured: null, wanted: [1, 0, 0] });
"""


@pytest.mark.parametrize(
    ("push", "back"),
    [
        ((0.05, 0.0, 0.0), "towards you"),
        ((-0.05, 0.0, 0.0), "away from you"),
        ((0.0, 0.05, 0.01), "to your right"),  # the operator's left is the robot's, +y
        ((0.0, -0.05, 0.0), "to your left"),
        ((0.01, 0.0, 0.05), "down"),
        ((0.0, 0.0, -0.05), "up"),
        ((0.03, 0.0, 0.05), "towards you and down"),
        ((0.03, 0.03, -0.03), "towards you and to your right and up"),
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


DRAWN = """
  globalThis.document = { documentElement: {} };
  globalThis.getComputedStyle = () => ({ fontSize: "14px" });
  globalThis.addEventListener = () => {};
  const { drawBack } = await load("back_arrow");
  const ends = [], words = [];
  const context = { canvas: { clientWidth: 640, clientHeight: 480 }, measureText: () => ({ width: 20 }) };
  context.lineTo = (...at) => ends.push(at);
  for (const name of ["moveTo", "beginPath", "stroke", "roundRect", "fill"]) context[name] = () => {};
  context.fillText = (text) => words.push(text);
  drawBack(context, ([, y, z]) => [320 + 1000 * y, 240 - 1000 * z], [0, 0, 0], v[0], v[1]);
  return [ends[0] ?? null, words];
"""


@pytest.mark.parametrize("limit", ["workspace", "obstacle", "reach", "leash"])
def test_the_arrow_points_where_the_words_send_the_hand(limit: str) -> None:
    tip, words = run(DRAWN, (0.0, 0.0, 0.05), limit)
    assert tip == [320, 330]  # down, 90 mm
    assert words == ["back"]


@pytest.mark.parametrize(("tool", "tip"), [((0.0, 0.0, -0.2), (320.0, 473.5)), ((0.0, 0.0, -0.6), (320.0, 840.0))])
def test_the_head_of_the_arrow_stays_in_the_picture(tool: tuple[float, ...], tip: tuple[float, ...]) -> None:
    """With half a head beside it; it is drawn from the tool, wherever that is."""
    wanted = (tool[0], tool[1], tool[2] + 0.05)
    assert run(DRAWN.replace("[0, 0, 0]", "v[2]"), wanted, "reach", tool)[0] == pytest.approx(tip, abs=0.02)


@pytest.mark.parametrize(("wanted", "limit"), [((0.0, 0.0, 0.05), "speed limit"), (None, "reach")])
def test_without_a_way_back_only_the_limit_is_named(wanted: tuple[float, ...] | None, limit: str) -> None:
    assert run(DRAWN, wanted, limit) == [None, [limit]]
