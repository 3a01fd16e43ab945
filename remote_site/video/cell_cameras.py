"""Views of the simulated cell, rendered off screen from its snapshot, so that the physics never waits for a picture."""

import os
from collections.abc import Sequence
from typing import Any

import cv2
import mujoco
import numpy as np

from common.cameras.camera import Frame, Image
from common.errors import CameraError
from remote_site.shared_memory import Record, SharedRecord
from remote_site.simulation.cell import Cell

MAX_GEOMS = 500
EFFECTS = (
    mujoco.mjtRndFlag.mjRND_SHADOW,
    mujoco.mjtRndFlag.mjRND_REFLECTION,
    mujoco.mjtRndFlag.mjRND_SKYBOX,
    mujoco.mjtRndFlag.mjRND_HAZE,
)
CURE = "on Debian and Ubuntu: apt-get install libegl1 libopengl0 libgl1-mesa-dri"


class CellRenderer:
    """One EGL context that renders every view; made and used by one process, after its fork."""

    def __init__(self, cell: Cell, width: int, height: int) -> None:
        self._model = cell.model
        self._data = mujoco.MjData(cell.model)
        self._model.vis.global_.offwidth, self._model.vis.global_.offheight = width, height
        self._gl: Any
        self._gl, self._context = _open_gl(self._model, width, height)
        self._scene = mujoco.MjvScene(self._model, MAX_GEOMS)
        for effect in EFFECTS:
            self._scene.flags[effect] = 0
        self._option, self._perturbation = mujoco.MjvOption(), mujoco.MjvPerturb()
        self._camera = mujoco.MjvCamera()
        self._camera.type = mujoco.mjtCamera.mjCAMERA_FIXED
        self._area = mujoco.MjrRect(0, 0, width, height)
        self._pixels = np.empty((height, width, 3), dtype=np.uint8)

    def view_id(self, name: str) -> int:
        """The number of a view by its name; CameraError names the views that exist."""
        names = [self._model.cam(i).name for i in range(self._model.ncam)]
        if name not in names:
            raise CameraError(f"camera {name}: the simulated cell has no such view; it has {', '.join(names)}")
        return names.index(name)

    def render(self, view: int, qpos: Record) -> Image:
        """A view (height, width, 3), BGR, of the cell in a posture (all of MuJoCo's qpos)."""
        model, data = self._model, self._data
        data.qpos[:] = qpos
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        mujoco.mj_camlight(model, data)
        self._camera.fixedcamid = view
        everything = mujoco.mjtCatBit.mjCAT_ALL
        mujoco.mjv_updateScene(model, data, self._option, self._perturbation, self._camera, everything, self._scene)
        mujoco.mjr_render(self._area, self._scene, self._context)
        mujoco.mjr_readPixels(self._pixels, None, self._area, self._context)
        return np.asarray(cv2.cvtColor(cv2.flip(self._pixels, 0), cv2.COLOR_RGB2BGR), dtype=np.uint8)

    def close(self) -> None:
        """Give the context back; further calls do nothing."""
        if self._gl is not None:
            self._context.free()
            self._gl.free()
            self._gl = None


class CellCamera:
    """One simulated view; a frame is stamped with the instant of the posture that it shows."""

    noise_free = True

    def __init__(self, name: str, renderer: CellRenderer, snapshot: SharedRecord) -> None:
        self.name = name
        self._renderer = renderer
        self._snapshot = snapshot
        self._view = renderer.view_id(name)
        self._frame: Frame | None = None
        self._seq = 0

    def newest(self) -> Frame | None:
        """The view of the newest posture, rendered only if it is new; None before the cell's first step."""
        snapshot = self._snapshot.read()
        capture_ns = int(snapshot["t_ns"])
        if capture_ns > (self._frame.capture_ns if self._frame else 0):
            self._frame = Frame(self._renderer.render(self._view, snapshot["qpos"]), capture_ns, self._seq)
            self._seq += 1
        return self._frame

    def close(self) -> None:
        """Give the context back, which all views share."""
        self._renderer.close()


def open_cell_cameras(
    names: Sequence[str], cell: Cell, snapshot: SharedRecord, width: int, height: int
) -> list[CellCamera]:
    """Simulated cameras by the names of their views, on one context; CameraError says what is missing."""
    renderer = CellRenderer(cell, width, height)
    return [CellCamera(name, renderer, snapshot) for name in names]


def _open_gl(model: mujoco.MjModel, width: int, height: int) -> tuple[Any, mujoco.MjrContext]:
    # Mesa's software renderer would spread a small picture over threads, at more processor time than it saves.
    os.environ.setdefault("LP_NUM_THREADS", "0")
    try:
        from mujoco.egl import GLContext  # noqa: PLC0415  # EGL loads only in the process that renders

        gl = GLContext(width, height)
        gl.make_current()
        context = mujoco.MjrContext(model, mujoco.mjtFontScale.mjFONTSCALE_50)
    except Exception as error:  # PyOpenGL fails with many kinds where a library is missing
        raise CameraError(f"simulated views need EGL, which does not start here ({error}); {CURE}") from error
    mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN, context)
    return gl, context
