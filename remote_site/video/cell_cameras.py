"""Views of the simulated cell, rendered off screen through EGL from its snapshot: the physics never waits for them."""

import os
from collections.abc import Sequence
from typing import Any

import cv2
import mujoco
import numpy as np

from common.cameras.camera import Frame, Image
from common.errors import CameraError
from remote_site.shared_record import Record, SharedRecord
from remote_site.simulation.cell import Cell
from remote_site.simulation.scenery import ROOM_GROUP
from remote_site.video.config import VideoConfig
from remote_site.video.streaming.clock_strip import draw_clock

MAX_GEOMS = 500
WORLD = 0
CURE = "on Debian and Ubuntu: apt-get install libegl1 libopengl0 libgl1-mesa-dri"
EFFECTS = (
    mujoco.mjtRndFlag.mjRND_SHADOW,
    mujoco.mjtRndFlag.mjRND_REFLECTION,
    mujoco.mjtRndFlag.mjRND_SKYBOX,
    mujoco.mjtRndFlag.mjRND_HAZE,
)


class OffScreen:
    """A picture of `width` x `height` pixels to draw scenes into; CameraError with the cure where EGL is missing."""

    def __init__(self, model: mujoco.MjModel, width: int, height: int) -> None:
        model.vis.global_.offwidth, model.vis.global_.offheight = width, height
        self._gl, self._context, self._functions = _open_egl(model, width, height)
        mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN, self._context)
        self._area = mujoco.MjrRect(0, 0, width, height)
        self._pixels: Image = np.empty((height, width, 4), dtype=np.uint8)

    def draw(self, scene: mujoco.MjvScene) -> Image:
        """The scene as (height, width, 4) RGBA, bottom row first, alpha 0 where nothing is; valid until the next."""
        mujoco.mjr_render(self._area, scene, self._context)
        # mjr_readPixels gives RGB alone, which takes the software renderer ten times as long.
        gl, (height, width, _) = self._functions, self._pixels.shape
        gl.glReadPixels(0, 0, width, height, gl.GL_RGBA, gl.GL_UNSIGNED_BYTE, self._pixels)
        return self._pixels

    def close(self) -> None:
        """Release the context; further calls do nothing."""
        if self._gl is not None:
            self._context.free()
            self._gl.free()
            self._gl = None


class CellRenderer:
    """Renders every view on one EGL context; made and used by one process, after its fork.

    A fixed camera draws the room once and keeps it as its background: the room is behind everything.
    """

    def __init__(self, cell: Cell, width: int, height: int) -> None:
        self._model = cell.model
        self._data = mujoco.MjData(cell.model)
        self._screen = OffScreen(cell.model, width, height)
        self._scene = mujoco.MjvScene(cell.model, MAX_GEOMS)
        for effect in EFFECTS:
            self._scene.flags[effect] = 0
        self._option, self._perturbation = mujoco.MjvOption(), mujoco.MjvPerturb()
        self._camera = mujoco.MjvCamera()
        self._camera.type = mujoco.mjtCamera.mjCAMERA_FIXED
        self._backgrounds: dict[int, Image] = {}

    def view_id(self, name: str) -> int:
        """The number of a view by its name; CameraError names the views that exist."""
        names = [self._model.cam(i).name for i in range(self._model.ncam)]
        if name not in names:
            raise CameraError(f"camera {name}: the simulated cell has no such view; it has {', '.join(names)}")
        return names.index(name)

    def render(self, view: int, qpos: Record) -> Image:
        """A view (height, width, 3), BGR, of the cell in a posture (all of MuJoCo's qpos)."""
        self._data.qpos[:] = qpos
        mujoco.mj_kinematics(self._model, self._data)
        mujoco.mj_comPos(self._model, self._data)
        mujoco.mj_camlight(self._model, self._data)
        if self._model.cam_bodyid[view] != WORLD:
            return _bgr(self._draw(view, room=True, things=True))
        if view not in self._backgrounds:
            self._backgrounds[view] = _bgr(self._draw(view, room=True, things=False))
        drawn = self._draw(view, room=False, things=True)
        picture, nothing = _bgr(drawn), cv2.bitwise_not(cv2.extractChannel(drawn, 3))
        return _image(cv2.copyTo(self._backgrounds[view], nothing, picture))

    def close(self) -> None:
        """Release the context; further calls do nothing."""
        self._screen.close()

    def _draw(self, view: int, *, room: bool, things: bool) -> Image:
        self._camera.fixedcamid = view
        self._option.geomgroup[:] = things
        self._option.geomgroup[ROOM_GROUP] = room
        mujoco.mjv_updateScene(
            self._model,
            self._data,
            self._option,
            self._perturbation,
            self._camera,
            mujoco.mjtCatBit.mjCAT_ALL,
            self._scene,
        )
        return _image(cv2.flip(self._screen.draw(self._scene), 0))


class CellCamera:
    """One simulated view; a frame is stamped with the instant of the posture that it shows.

    With `clock` it also shows this instant on this host's monotonic clock, machine-readable (clock_strip).
    """

    noise_free = True

    def __init__(self, name: str, renderer: CellRenderer, snapshot: SharedRecord, *, clock: bool) -> None:
        self.name = name
        self._renderer = renderer
        self._snapshot = snapshot
        self._clock = clock
        self._view = renderer.view_id(name)
        self._frame: Frame | None = None
        self._seq = 0

    def newest(self) -> Frame | None:
        """The view of the newest posture, rendered only if it is new; None before the cell's first step."""
        snapshot = self._snapshot.read()
        capture_ns = int(snapshot["t_ns"])
        if capture_ns > (self._frame.capture_ns if self._frame else 0):
            image = self._renderer.render(self._view, snapshot["qpos"])
            if self._clock:
                draw_clock(image, capture_ns)
            self._frame = Frame(image, capture_ns, self._seq)
            self._seq += 1
        return self._frame

    def close(self) -> None:
        """Release the context, which all views share."""
        self._renderer.close()


def open_cell_cameras(
    names: Sequence[str], cell: Cell, snapshot: SharedRecord, config: VideoConfig
) -> list[CellCamera]:
    """Simulated cameras by the names of their views, on one context; CameraError names what is missing."""
    renderer = CellRenderer(cell, config.width, config.height)
    return [CellCamera(name, renderer, snapshot, clock=config.clock) for name in names]


def _bgr(rgba: Image) -> Image:
    return _image(cv2.cvtColor(rgba, cv2.COLOR_RGBA2BGR))


def _image(array: object) -> Image:
    return np.asarray(array, dtype=np.uint8)


def _open_egl(model: mujoco.MjModel, width: int, height: int) -> tuple[Any, mujoco.MjrContext, Any]:
    # Mesa's software renderer would spread a small picture over threads, at more processor time than it saves.
    os.environ.setdefault("LP_NUM_THREADS", "0")
    try:
        from mujoco.egl import GLContext  # noqa: PLC0415  # EGL loads only in the process that renders
        from OpenGL import GL  # noqa: PLC0415  # after mujoco.egl, which makes it use EGL

        gl = GLContext(width, height)
        gl.make_current()
        return gl, mujoco.MjrContext(model, mujoco.mjtFontScale.mjFONTSCALE_50), GL
    except Exception as error:  # PyOpenGL fails with many kinds where a library is missing
        raise CameraError(f"simulated views need EGL, which does not start here ({error}); {CURE}") from error
