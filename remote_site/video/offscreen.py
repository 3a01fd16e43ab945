"""Off-screen rendering of a MuJoCo scene through EGL: one context of one process, opened after its fork."""

import os
from typing import Any

import mujoco
import numpy as np

from common.cameras.camera import Image
from common.errors import CameraError

CURE = "on Debian and Ubuntu: apt-get install libegl1 libopengl0 libgl1-mesa-dri"


class OffScreen:
    """A picture of `width` x `height` pixels to draw scenes into; CameraError with the cure where EGL is missing."""

    def __init__(self, model: mujoco.MjModel, width: int, height: int) -> None:
        model.vis.global_.offwidth, model.vis.global_.offheight = width, height
        self._gl, self._context, self._functions = _open(model, width, height)
        mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN, self._context)
        self._area = mujoco.MjrRect(0, 0, width, height)
        self._pixels: Image = np.empty((height, width, 4), dtype=np.uint8)

    def draw(self, scene: mujoco.MjvScene) -> Image:
        """The scene as (height, width, 4) RGBA, bottom row first, alpha 0 where nothing is; valid until the next."""
        mujoco.mjr_render(self._area, scene, self._context)
        # mjr_readPixels gives RGB alone, which costs the software renderer ten times as much to convert.
        gl, (height, width, _) = self._functions, self._pixels.shape
        gl.glReadPixels(0, 0, width, height, gl.GL_RGBA, gl.GL_UNSIGNED_BYTE, self._pixels)
        return self._pixels

    def close(self) -> None:
        """Give the context back; further calls do nothing."""
        if self._gl is not None:
            self._context.free()
            self._gl.free()
            self._gl = None


def _open(model: mujoco.MjModel, width: int, height: int) -> tuple[Any, mujoco.MjrContext, Any]:
    # Mesa's software renderer would spread a small picture over threads, at more processor time than it saves.
    os.environ.setdefault("LP_NUM_THREADS", "0")
    try:
        from mujoco.egl import GLContext  # noqa: PLC0415  # EGL loads only in the process that renders
        from OpenGL import GL  # noqa: PLC0415  # after mujoco.egl, which tells it to use EGL

        gl = GLContext(width, height)
        gl.make_current()
        return gl, mujoco.MjrContext(model, mujoco.mjtFontScale.mjFONTSCALE_50), GL
    except Exception as error:  # PyOpenGL fails with many kinds where a library is missing
        raise CameraError(f"simulated views need EGL, which does not start here ({error}); {CURE}") from error
