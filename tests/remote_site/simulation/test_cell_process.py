"""The cell's process in real time: it keeps its pace, stops when commands cease, and ends only with the arm at rest."""

import multiprocessing
import os
import signal
import time
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from common.process.children import END, Children, Heartbeat
from common.process.service import StopFlag
from lab.stage.waiting import until
from remote_site.kinematics.config import RobotConfig
from remote_site.simulation import process
from remote_site.simulation.config import CellConfig, ServoConfig
from remote_site.simulation.controller import ControllerFault
from remote_site.simulation.memory import CellMemory

FORK = multiprocessing.get_context("fork")
ROBOT = RobotConfig()
SPEED = 0.5
CONFIG = CellConfig(servo=ServoConfig(watchdog_ms=1000.0))  # a busy machine may keep the commander waiting


class Rig:
    """A running cell, and its readings at each of its steps that were seen."""

    def __init__(self) -> None:
        self.memory = CellMemory.create(6)
        self.children = Children("remote")
        self.child = self.children.start("cell", self.run)
        self.children.wait_ready(30.0, StopFlag())
        self.log: list[Any] = []

    def run(self, should_stop: StopFlag, heartbeat: Heartbeat) -> None:
        process.run_cell(process.SimulatedCell(CONFIG, ROBOT, self.memory), should_stop, heartbeat.beat)

    def watch(self, until: Callable[[Any], object], seconds: float = 30.0) -> None:
        """Keep every new reading until one fulfils `until`."""
        deadline = time.monotonic() + seconds
        while time.monotonic() < deadline:
            reading = self.memory.reading.read()
            if not self.log or reading["t_ns"] != self.log[-1]["t_ns"]:
                self.log.append(reading)
            if until(reading):
                return
            time.sleep(0.0005)
        pytest.fail(f"not reached in {seconds} s; last reading {self.log[-1]}")

    def column(self, key: str) -> np.ndarray:
        return np.array([reading[key] for reading in self.log])


def turn_joint_1(memory: CellMemory) -> None:
    """Activate, speed joint 1 up smoothly, then keep turning it to and fro until killed."""
    setup, command = np.zeros((), memory.setup.dtype), np.zeros((), memory.command.dtype)
    setup[()] = (1_000_000_000, 10.0, 100.0, 25.0)
    memory.setup.write(setup)
    command["activation"], command["run"], command["q"] = 1, True, ROBOT.start
    start_ns = time.monotonic_ns()
    for seq in range(1_000_000):
        t = (time.monotonic_ns() - start_ns) / 1e9
        rate = SPEED / 0.25
        command["seq"], command["t_ns"] = seq, time.monotonic_ns()
        command["q"][0] = 0.25 * np.sin(rate * t) ** 2
        command["dq"][0] = 0.25 * rate * np.sin(2 * rate * t)
        command["ddq"][0] = 0.5 * rate * rate * np.cos(2 * rate * t)
        memory.command.write(command)
        time.sleep(0.004)


@pytest.fixture
def rig():
    rig = Rig()
    yield rig
    rig.children.end()


@pytest.fixture
def moving(rig):
    writer = FORK.Process(target=turn_joint_1, args=(rig.memory,))
    writer.start()
    rig.watch(lambda reading: reading["dq"][0] > 0.4)
    yield rig, writer
    writer.kill()
    writer.join(5)


@pytest.mark.slow
def test_the_arm_stops_within_limits_when_its_commander_is_killed(moving):
    rig, writer = moving
    os.kill(writer.pid, signal.SIGKILL)
    rig.watch(lambda reading: reading["fault"] == ControllerFault.WATCHDOG and reading["resting"])
    rested_ns = rig.log[-1]["t_ns"]
    rig.watch(lambda reading: reading["t_ns"] > rested_ns + 200_000_000)
    t, dq = rig.column("t_ns") / 1e9, rig.column("dq")
    stopped = t > t[-1] - 0.1
    assert np.abs(dq[stopped]).max() < 1e-3
    deceleration = np.abs(np.diff(dq[:, 0]) / np.diff(t))
    most = ServoConfig().max_acceleration_rad_s2[0]
    assert deceleration.max() < 1.05 * most  # the measured arm overshoots the commanded one a little
    assert not rig.log[-1]["active"]


@pytest.mark.slow
def test_a_commander_that_comes_back_does_not_move_the_arm_unasked(moving):
    rig, writer = moving
    os.kill(writer.pid, signal.SIGKILL)
    rig.watch(lambda reading: reading["fault"] == ControllerFault.WATCHDOG and reading["resting"])
    command = rig.memory.command.read().copy()
    rest = rig.memory.reading.read()["q"].copy()
    for _ in range(30):
        command["seq"] += 1
        command["q"][0] += 0.01
        rig.memory.command.write(command)
        time.sleep(0.004)
    assert np.abs(rig.memory.reading.read()["q"] - rest).max() < 1e-3


def test_told_to_end_the_cell_stops_the_arm_first(moving):
    rig, _ = moving
    os.kill(rig.child.process.pid, END)
    rig.child.process.join(30)
    assert rig.child.process.exitcode == 0
    last = rig.memory.reading.read()
    assert last["resting"]
    assert np.abs(last["dq"]).max() < 1e-2


def test_an_interrupt_from_the_terminal_is_left_to_the_parent(rig):
    os.kill(rig.child.process.pid, signal.SIGINT)
    beat = rig.child.heartbeat.last_ns
    rig.watch(lambda reading: reading["t_ns"] > beat + 50_000_000)
    assert rig.child.process.is_alive()


def test_steps_are_stamped_one_period_apart_on_this_hosts_clock(rig):
    before = time.monotonic_ns()
    rig.watch(lambda reading: reading["t_ns"] > before + 300_000_000)
    steps = np.diff(rig.column("t_ns"))
    assert (steps >= 2_000_000).all()
    assert np.median(steps % 2_000_000) == 0


def parent_of_a_cell(memory: CellMemory, pids: Any) -> None:
    children = Children("remote")
    cell = process.SimulatedCell(CONFIG, ROBOT, memory)
    child = children.start("cell", lambda stop, beat: process.run_cell(cell, stop, beat.beat))
    children.wait_ready(30.0, StopFlag())
    pids[0] = child.process.pid
    time.sleep(60)


def test_the_cell_outlives_its_parent_only_to_stop_the_arm():
    memory, pids = CellMemory.create(6), FORK.Array("q", 1)
    parent = FORK.Process(target=parent_of_a_cell, args=(memory, pids))
    parent.start()
    until(lambda: pids[0])
    writer = FORK.Process(target=turn_joint_1, args=(memory,))
    writer.start()
    until(lambda: memory.reading.read()["dq"][0] > 0.4)
    parent.kill()
    parent.join(5)
    until(lambda: not is_running(pids[0]))
    last = memory.reading.read()
    writer.kill()
    writer.join(5)
    assert last["resting"]
    assert np.abs(last["dq"]).max() < 1e-2


def test_a_cell_beats_after_each_step(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(process, "ask_for_real_time", lambda _priority: True)
    cell, steps = process.SimulatedCell(CONFIG, ROBOT, CellMemory.create(6)), list[int]()
    process.run_cell(cell, lambda: len(steps) >= 6, lambda: steps.append(round(cell.data.time / cell.dt)))
    assert steps == [1, 2, 3, 4, 5, 6]


def is_running(pid: int) -> bool:
    try:
        with open(f"/proc/{pid}/stat", encoding="ascii") as stat:
            return stat.read().rsplit(")", 1)[1].split()[0] != "Z"
    except FileNotFoundError:
        return False
