"""The simulated arm follows the operator's pick and place, and the block goes with it."""

from collections.abc import Sequence
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from common.messages.robot import GripperCommand, GripperStatus
from remote_site.drivers.driver import GripperReading
from remote_site.drivers.supervisor.grip import GripSettings, GripWatch
from remote_site.kinematics.config import RobotConfig
from remote_site.simulation.config import BlockConfig, CellConfig
from remote_site.simulation.controller import ControllerFault
from remote_site.simulation.memory import GRIPPER_COMMANDS, CellMemory
from remote_site.simulation.process import SimulatedCell
from tests.present import present
from tests.remote_site.simulation.cell_motion import PICK_AND_PLACE, Stage, arm_model, sample

ROBOT = RobotConfig()
STEP_NS = 2_000_000


def play(
    block: BlockConfig, stages: Sequence[Stage] = PICK_AND_PLACE, speed: float = 0.15, grip_n: float = 25.0
) -> SimpleNamespace:
    """Run a motion in simulated time and keep what happens at each setpoint."""
    memory = CellMemory.create(6)
    cell = SimulatedCell(CellConfig(block=block), ROBOT, memory)
    setup, command = np.zeros((), memory.setup.dtype), np.zeros((), memory.command.dtype)
    setup[()] = (100_000_000, 10.0, 100.0, grip_n)
    memory.setup.write(setup)
    command["activation"], command["run"], command["q"] = 1, True, ROBOT.start
    memory.command.write(command)
    cell.step(STEP_NS, STEP_NS)
    now_ns, seen, watch = STEP_NS, [], GripWatch(GripSettings())
    for seq, (q, dq, ddq, opened) in enumerate(zip(*sample(stages, ROBOT, speed), strict=True), start=1):
        gripper = GripperCommand.OPEN if opened else GripperCommand.CLOSED
        command[()] = (seq, now_ns, 1, True, GRIPPER_COMMANDS.index(gripper), q, dq, ddq)
        memory.command.write(command)
        for _ in range(2):
            now_ns += STEP_NS
            cell.step(now_ns, now_ns)
        reading = memory.reading.read()
        watch.observe(GripperReading(float(reading["opening_m"]), float(reading["force_n"])), now_ns, gripper)
        seen.append(look(cell, reading) | {"status": present(watch.state).status})
    return SimpleNamespace(**{key: np.array([moment[key] for moment in seen]) for key in seen[0]})


def look(cell: SimulatedCell, reading: Any) -> dict[str, Any]:
    model, data = cell.cell.model, cell.data
    contacts = {frozenset(model.geom(g).name for g in pair) for pair in data.contact.geom}
    body = data.body("block")
    return {
        "q": reading["q"],
        "wanted": cell.controller.motion.q,
        "force": float(reading["force_n"]),
        "opening": float(reading["opening_m"]),
        "active": bool(reading["active"]),
        "fault": ControllerFault(int(reading["fault"])),
        "speed": float(np.abs(reading["dq"]).max()),
        "block": body.xpos.copy(),
        "upright": body.xmat[8],
        "table_hit": any("table" in pair and "block" not in pair for pair in contacts),
    }


@pytest.fixture(scope="module")
def seen():
    return play(BlockConfig())


def test_the_block_is_lifted_moved_and_set_down_on_its_target(seen):
    start, end = seen.block[0], seen.block[-1]
    assert seen.block[:, 2].max() - start[2] > 0.035
    assert end - start == pytest.approx([0, -0.2, 0], abs=0.003)
    assert seen.upright.min() > np.cos(np.radians(3))


def test_the_grip_stays_below_its_limit_and_holds_the_block_across(seen):
    held = seen.block[:, 2] - seen.block[0, 2] > 0.03
    assert seen.force.max() <= CellConfig().gripper.force_limit_n
    assert seen.force[held].min() > 10
    assert seen.opening[held] == pytest.approx(np.full(held.sum(), 0.05), abs=0.001)


def test_the_grasp_of_the_block_is_told_and_so_is_its_end(seen):
    held = seen.block[:, 2] - seen.block[0, 2] > 0.03
    assert set(seen.status[held]) == {GripperStatus.HOLDING}
    assert GripperStatus.CLOSED not in set(seen.status)
    assert GripperStatus.TIMED_OUT not in set(seen.status)
    assert seen.status[125] == GripperStatus.OPEN
    assert seen.status[-1] == GripperStatus.OPEN


def test_the_grip_keeps_the_force_limit_it_is_given():
    gentle = play(BlockConfig(), grip_n=8.0)
    held = gentle.block[:, 2] - gentle.block[0, 2] > 0.03
    assert held.any()
    assert gentle.force.max() <= 8.0
    assert gentle.force[held].min() > 4.0


def test_a_grip_beside_the_block_is_closed_on_nothing():
    beside = ((0.0, 0.0, 0.0, True), (0.0, 0.0, 0.01, False), (0.0, 0.0, 0.0, False))
    assert play(BlockConfig(), beside).status[-1] == GripperStatus.CLOSED


def test_the_arm_follows_within_a_millimetre(seen):
    model = arm_model(ROBOT)
    error = [
        np.linalg.norm((model.forward(q) - model.forward(w))[:3, 3]) for q, w in zip(seen.q, seen.wanted, strict=True)
    ]
    assert max(error) < 0.001
    assert seen.active.all()


def test_nothing_but_the_block_touches_the_table(seen):
    assert not seen.table_hit.any()


@pytest.mark.slow
def test_an_off_centre_block_is_taken_too():
    moved = play(BlockConfig(centre_xy_m=(0.547, 0.005)))
    assert moved.block[:, 2].max() - moved.block[0, 2] > 0.035


def test_an_arm_driven_into_the_table_is_blocked_and_holds():
    into_the_table = (
        (0.0, 0.0, 0.0, True),
        (0.10, 0.15, -0.45, True),
        (0.10, 0.15, -0.45, True),
        (0.0, 0.0, 0.0, True),
    )
    seen = play(BlockConfig(), into_the_table, speed=0.3)
    assert seen.fault[-1] == ControllerFault.BLOCKED
    assert seen.table_hit.any()
    after = np.flatnonzero(seen.fault == ControllerFault.BLOCKED)[125:]
    assert seen.speed[after].max() < 0.05
    assert np.abs(seen.q[after] - seen.q[after[-1]]).max() < 0.01
