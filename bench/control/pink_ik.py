"""Pink with daqp, to compare with our own solvers: installed into a folder of its own, without our dependencies."""

import importlib
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin

from bench.installing import PIP, UnavailableError, run_quietly
from common.geometry import Array

FOLDER = Path("build") / "pink"
PACKAGES = ("pin-pink==4.4.0", "qpsolvers", "loop-rate-limiters")
INSTALL_S = 120.0


class Pink:
    """One arm with a frame and a posture task, solved one tick at a time; UnavailableError states why not."""

    def __init__(self, model: pin.Model, frame: str, q: Array, dt: float) -> None:
        self._pink, self._tasks_module = _import()
        configuration, tasks = self._pink.Configuration, self._tasks_module
        self._configuration: Any = configuration(model, model.createData(), q.copy())
        self._frame = tasks.FrameTask(frame, position_cost=1.0, orientation_cost=0.3)
        self._posture = tasks.PostureTask(cost=1e-3)
        self._posture.set_target(q)
        self._dt = dt

    def step(self, base_T_target: Array) -> None:
        """Solve and integrate one tick towards a pose (4 x 4)."""
        self._frame.set_target(pin.SE3(base_T_target))
        tasks = [self._frame, self._posture]
        velocity = self._pink.solve_ik(self._configuration, tasks, self._dt, solver="daqp", safety_break=False)
        self._configuration.integrate_inplace(velocity, self._dt)

    def off_mm(self, base_T_target: Array, frame: str) -> float:
        """How far the tool is from a pose, mm."""
        pose = self._configuration.get_transform_frame_to_world(frame)
        return float(np.linalg.norm(pose.translation - base_T_target[:3, 3]) * 1e3)


def _import() -> tuple[Any, Any]:
    if not FOLDER.exists():
        run_quietly([sys.executable, *PIP, "--no-deps", "--target", str(FOLDER), *PACKAGES], INSTALL_S)
    if str(FOLDER) not in sys.path:
        sys.path.append(str(FOLDER))
    try:
        return importlib.import_module("pink"), importlib.import_module("pink.tasks")
    except ImportError as error:
        raise UnavailableError(str(error)) from error
