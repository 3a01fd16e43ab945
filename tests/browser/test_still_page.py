"""What the page draws besides pictures is drawn again only where it has changed."""

from collections import Counter
from functools import partial

import msgspec
import numpy as np

from bench.page import scene
from common.messages.robot import Pose, SessionState
from tests.browser.told import Told

TELLS = 20
COUNT = """() => {
  window.repaints ??= new Map();
  const kind = CanvasRenderingContext2D.prototype;
  if (!kind.counted) {
    const erase = kind.clearRect;
    kind.counted = true;
    kind.clearRect = function (...area) {
      const name = this.canvas.id || "over a picture";
      window.repaints.set(name, (window.repaints.get(name) ?? 0) + 1);
      return erase.apply(this, area);
    };
  }
  const counted = Object.fromEntries(window.repaints);
  window.repaints.clear();
  return counted;
}"""

OVER_A_PICTURE = """async ([cell, camera, robots]) => {
  const { Ghost } = await import("/static/ghost.js");
  const { ToolMarks } = await import("/static/tool_marks.js");
  const drawn = [];
  for (const Marks of [Ghost, ToolMarks]) {
    const canvas = document.createElement("canvas");
    document.body.append(canvas);
    const context = canvas.getContext("2d");
    const marks = new Marks(canvas, camera);
    let strokes = 0;
    context.stroke = () => (strokes += 1);
    drawn.push(robots.map((robot) => {
      strokes = 0;
      const tool = { ...robot.base_T_tool };
      if (Marks === Ghost) marks.draw(cell, robot);
      else marks.draw({ measured: tool, sent: tool, wanted: null, limit: null }, tool);
      return strokes > 0;
    }));
    canvas.remove();
  }
  return drawn;
}"""


def engaged(turned_rad: float = 0.0):
    """A state whose arm stands still, turned from the start posture."""
    q = scene.CONFIG.robot.start + turned_rad
    tool = Pose.from_transform(scene.MODEL.forward(q))
    posture = {"q": tuple(q.tolist()), "q_commanded": tuple((q + 0.05).tolist()), "base_T_tool": tool}
    return partial(scene.state, SessionState.ENGAGED, "ok", "the arm follows the hand", **posture)


def repaints(told: Told) -> Counter[str]:
    """How often each canvas was erased while the same was told again and again, once it was shown."""
    counts: list[Counter[str]] = []

    def told_often() -> bool:
        counts.append(Counter(told.page.page.evaluate(COUNT)))
        return len(counts) > 2 * TELLS

    told.until("the same state again and again", told_often)
    return sum(counts[TELLS:], Counter())


def test_an_arm_that_stands_still_is_not_drawn_again(told: Told) -> None:
    told.state = engaged()
    assert repaints(told)["arm"] == 0


def test_an_arm_that_moves_is_drawn_again_in_the_room_and_over_the_pictures(told: Told) -> None:
    told.state = engaged()
    repaints(told)
    told.state = engaged(0.2)
    seen: dict[str, int] = {}

    def all_drawn() -> bool:
        seen.update(told.page.page.evaluate(COUNT))
        return {"arm", "over a picture"} <= set(seen)

    told.until("both drawings", all_drawn)


def test_what_nobody_can_see_is_no_change(told: Told) -> None:
    told.state = engaged()
    repaints(told)
    chance = np.random.default_rng(1)

    def trembling():
        return engaged(chance.uniform(-1e-5, 1e-5))()

    told.state = trembling
    assert repaints(told)["arm"] == 0


def test_what_is_drawn_over_a_picture_is_drawn_again_only_where_it_has_moved(told: Told) -> None:
    cell = scene.cell()
    robots = [engaged(turned)() for turned in (0.0, 1e-6, 0.2, 0.2)]
    told_to_it = msgspec.to_builtins([cell, cell.cameras[0], robots])
    for drawn in told.page.page.evaluate(OVER_A_PICTURE, told_to_it):
        assert drawn == [True, False, True, False]
