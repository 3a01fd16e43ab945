"""What the page draws besides pictures is drawn again only where it has changed."""

from collections.abc import Callable
from functools import partial

import msgspec
import pytest

from common.messages.robot import Pose, RobotState, SessionState
from lab.measure.page import scene
from tests.browser.told import Told, opened_told

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

IN_THE_ROOM = """async ([cell, robots]) => {
  const { ArmRoom } = await import("/static/arm_room.js");
  const room = new ArmRoom();
  room.describe(cell);
  const context = document.getElementById("arm").getContext("2d");
  let erased = 0;
  context.clearRect = () => (erased += 1);
  const drawn = robots.map((robot) => {
    erased = 0;
    room.show(robot);
    room.refresh();
    return erased > 0;
  });
  delete context.clearRect;
  return drawn;
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


def engaged(turned_rad: float = 0.0) -> Callable[..., RobotState | None]:
    """A state whose arm stands still, turned from the start posture."""
    q = scene.CONFIG.robot.start + turned_rad
    tool = Pose.from_transform(scene.MODEL.forward(q))
    posture = {"q": tuple(q.tolist()), "q_commanded": tuple((q + 0.05).tolist()), "base_T_tool": tool}
    return partial(scene.state, SessionState.ENGAGED, "ok", "the arm follows the hand", **posture)


@pytest.mark.slow
def test_an_arm_is_drawn_again_only_where_it_has_moved_as_far_as_can_be_seen(browser: object) -> None:
    robots = [{**msgspec.to_builtins(engaged(turned)()), "silent": False} for turned in (0.0, 1e-5, 0.2, 0.2)]
    with opened_told(browser) as told:  # a page of its own, which then has two drawings of the arm
        drawn = told.page.page.evaluate(IN_THE_ROOM, [msgspec.to_builtins(scene.cell()), robots])
    assert drawn == [True, False, True, False]


def test_an_arm_that_moves_is_drawn_again_in_the_room_and_over_the_pictures(told: Told) -> None:
    told.page.page.evaluate(COUNT)
    told.state = engaged(0.2)
    seen: dict[str, int] = {}

    def all_drawn() -> bool:
        seen.update(told.page.page.evaluate(COUNT))
        return {"arm", "over a picture"} <= set(seen)

    told.until("both drawings", all_drawn)


def test_what_is_drawn_over_a_picture_is_drawn_again_only_where_it_has_moved(told: Told) -> None:
    cell = scene.cell()
    robots = [engaged(turned)() for turned in (0.0, 1e-6, 0.2, 0.2)]
    told_to_it = msgspec.to_builtins([cell, cell.cameras[0], robots])
    for drawn in told.page.page.evaluate(OVER_A_PICTURE, told_to_it):
        assert drawn == [True, False, True, False]
