"""Views of the simulated cell, rendered off screen through EGL from its snapshot: the physics never waits for them."""

import itertools
import math
import os
from collections.abc import Sequence
from typing import Any, NamedTuple

import cv2
import mujoco
import numpy as np

from common.cameras.camera import Frame, Image
from common.errors import CameraError
from common.geometry import Array
from remote_site.shared_record import SharedRecord
from remote_site.simulation.cell import Cell
from remote_site.simulation.scenery import ROOM_GROUP, TABLE_MASK
from remote_site.simulation.views import OPENGL_R_IMAGE
from remote_site.video.backdrop import NEAR_M, Backdrop, Eye
from remote_site.video.config import VideoConfig

MAX_GEOMS = 500
WORLD = 0
FINER, SHARPENED = 3, 0.5
NOTHING, OPAQUE = 0, 255  # of a pixel's alpha
WINDOW_STEPS = 4  # of its width and of its height: for each size a frame buffer is kept
UNMOVED = 2e-5  # m or rad from the posture that was drawn: less than a tenth of a pixel in every view
STILL, ALL = mujoco.mjtCatBit.mjCAT_STATIC, mujoco.mjtCatBit.mjCAT_ALL
CURE = "on Debian and Ubuntu: apt-get install libegl1 libopengl0 libgl1-mesa-dri"
EFFECTS = (
    mujoco.mjtRndFlag.mjRND_SHADOW,
    mujoco.mjtRndFlag.mjRND_REFLECTION,
    mujoco.mjtRndFlag.mjRND_SKYBOX,
    mujoco.mjtRndFlag.mjRND_HAZE,
)


class DrawnArea(NamedTuple):
    """A part of a view: its upper left corner, which may lie between pixels, and its size, px."""

    left: float
    top: float
    width: int
    height: int


class OffScreen:
    """A picture of `width` x `height` pixels to draw scenes into; CameraError with the cure where EGL is missing."""

    def __init__(self, model: mujoco.MjModel, width: int, height: int) -> None:
        self._gl, self._context, self._functions = _open_egl(model, width, height)
        self._take_nearest_sizes()
        self._buffers: dict[tuple[int, int], int] = {}
        self._pixels: Image = np.empty(height * width * 4, dtype=np.uint8)

    def draw(self, scene: mujoco.MjvScene, width: int, height: int) -> Image:
        """The scene as (height, width, 4) RGBA, bottom row first, alpha 0 where nothing is; valid until the next."""
        gl, pixels = self._functions, self._pixels[: height * width * 4].reshape(height, width, 4)
        self._context.offFBO = self._buffer(width, height)
        mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN, self._context)
        mujoco.mjr_render(mujoco.MjrRect(0, 0, width, height), scene, self._context)
        # mjr_readPixels gives RGB alone, which takes the software renderer ten times as long.
        gl.glReadPixels(0, 0, width, height, gl.GL_RGBA, gl.GL_UNSIGNED_BYTE, pixels)
        return pixels

    def _buffer(self, width: int, height: int) -> int:
        """Return the frame buffer of just this size: a whole one is cleared several times as fast as a part of one.

        With MuJoCo's depth, which has a stencil with it, each picture takes the software renderer half as long again.
        It fills a depth of floating point a tenth quicker than one of whole numbers.
        """
        if (width, height) not in self._buffers:
            gl, self._buffers[width, height] = self._functions, self._functions.glGenFramebuffers(1)
            gl.glBindFramebuffer(gl.GL_FRAMEBUFFER, self._buffers[width, height])
            for place, kind in (
                (gl.GL_COLOR_ATTACHMENT0, gl.GL_RGBA8),
                (gl.GL_DEPTH_ATTACHMENT, gl.GL_DEPTH_COMPONENT32F),
            ):
                storage = gl.glGenRenderbuffers(1)
                gl.glBindRenderbuffer(gl.GL_RENDERBUFFER, storage)
                gl.glRenderbufferStorage(gl.GL_RENDERBUFFER, kind, width, height)
                gl.glFramebufferRenderbuffer(gl.GL_FRAMEBUFFER, place, gl.GL_RENDERBUFFER, storage)
        return self._buffers[width, height]

    def _take_nearest_sizes(self) -> None:
        """Draw one size of each texture: MuJoCo mixes two, which takes the software renderer twice as long."""
        gl = self._functions
        for texture in self._context.texture[: self._context.ntexture]:
            gl.glBindTexture(gl.GL_TEXTURE_2D, texture)
            gl.glTexParameteri(gl.GL_TEXTURE_2D, gl.GL_TEXTURE_MIN_FILTER, gl.GL_LINEAR_MIPMAP_NEAREST)

    def close(self) -> None:
        """Release the context; further calls do nothing."""
        if self._gl is not None:
            self._context.free()
            self._gl.free()
            self._gl = None


class CellRenderer:
    """Renders every view of a dressed cell on one EGL context; made and used by one process, after its fork.

    MuJoCo draws what moves, and the table as a mask; behind them comes what stands still. For a fixed camera that is
    drawn once, finer than the view, and kept, and only the part is drawn again in which something can be that moves.
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
        self._whole = DrawnArea(0.0, 0.0, width, height)
        self._moving = np.flatnonzero(cell.model.body_weldid[cell.model.geom_bodyid] != WORLD)
        self._boxes = _box_corners(cell.model.geom_aabb[self._moving])
        self._surfaces = Backdrop(cell.surfaces)
        self._kept: dict[int, Image] = {}

    def view_id(self, name: str) -> int:
        """The number of a view by its name; CameraError names the views that exist."""
        names = [self._model.cam(i).name for i in range(self._model.ncam)]
        if name not in names:
            raise CameraError(f"camera {name}: the simulated cell has no such view; it has {', '.join(names)}")
        return names.index(name)

    def render(self, view: int, qpos: Array) -> Image:
        """A view (height, width, 3), BGR, of the cell in a posture (all of MuJoCo's qpos)."""
        self._pose(qpos)
        if self._model.cam_bodyid[view] != WORLD:
            return self._drawn_anew(view)
        self.prepare(view)
        picture = self._kept[view].copy()
        window = self._where_things_move(view)
        if window is not None:
            self._draw_over(picture, view, window, ALL)
        return picture

    def prepare(self, view: int) -> None:
        """Draw what stands still in a fixed view, if that is not done yet: it takes as long as many pictures."""
        if self._model.cam_bodyid[view] == WORLD and view not in self._kept:
            self._pose(self._data.qpos)
            self._kept[view] = self._still(view)
            self._draw_over(self._kept[view], view, self._whole, STILL)

    def close(self) -> None:
        """Release the context; further calls do nothing."""
        self._screen.close()

    def _pose(self, qpos: Array) -> None:
        self._data.qpos[:] = qpos
        mujoco.mj_kinematics(self._model, self._data)
        mujoco.mj_comPos(self._model, self._data)
        mujoco.mj_camlight(self._model, self._data)

    def _drawn_anew(self, view: int) -> Image:
        picture, eye = self._draw(view, self._whole, room=True, things=True), self._eye(view)
        alpha = cv2.extractChannel(picture, 3)
        for of_table, unpainted in ((False, NOTHING), (True, TABLE_MASK)):
            self._surfaces.draw(eye, picture, (alpha == unpainted).view(np.uint8), of_table=of_table)
        return _bgr(picture)

    def _draw_over(self, picture: Image, view: int, window: DrawnArea, kinds: mujoco.mjtCatBit) -> None:
        """Draw these kinds of things into a window, whole pixels, of a fixed view's picture."""
        drawn = self._draw(view, window, room=False, things=True, kinds=kinds)
        left, top = int(window.left), int(window.top)
        part = picture[top : top + window.height, left : left + window.width]
        cv2.copyTo(_bgr(drawn), _where(drawn, OPAQUE), part)

    def _where_things_move(self, view: int) -> DrawnArea | None:
        """The smallest window, of 16 sizes, around the boxes of all that moves; None where the view has none of it."""
        _, _, width, height = self._whole
        turned = self._data.geom_xmat[self._moving].reshape(-1, 3, 3)
        corners = self._data.geom_xpos[self._moving][:, None] + self._boxes @ turned.transpose(0, 2, 1)
        eye = self._eye(view)
        seen = eye.seen(corners.reshape(-1, 3) - eye.position)
        if seen[:, 2].min(initial=math.inf) < NEAR_M:
            return self._whole
        points = seen[:, :2] / seen[:, 2:]
        low = np.maximum(np.floor(points.min(axis=0, initial=math.inf)) - 1, 0)
        high = np.minimum(np.ceil(points.max(axis=0, initial=-math.inf)) + 1, (width, height))
        if (high <= low).any():
            return None
        whole = np.array((width, height))
        size = np.ceil(np.ceil((high - low) / whole * WINDOW_STEPS) / WINDOW_STEPS * whole)
        low = np.minimum(low, whole - size)
        return DrawnArea(low[0], low[1], int(size[0]), int(size[1]))

    def _still(self, view: int) -> Image:
        """Room, furniture and table, several pixels to each of the view's, averaged and sharpened as cameras do."""
        size = (self._whole.width, self._whole.height)
        width, height = (FINER * pixels for pixels in size)
        fine: Image = np.empty((height, width, 4), dtype=np.uint8)
        for row, column in itertools.product(range(FINER), repeat=2):
            aside = ((column + 0.5) / FINER - 0.5, (row + 0.5) / FINER - 0.5)
            fine[row::FINER, column::FINER] = self._draw(
                view, self._whole._replace(left=aside[0], top=aside[1]), room=True, things=False
            )
        eye = self._eye(view, FINER)
        self._surfaces.draw(eye, fine, _where(fine, NOTHING), of_table=False)
        self._surfaces.draw(eye, fine, np.full((height, width), 255, dtype=np.uint8), of_table=True)
        averaged = cv2.resize(_bgr(fine), size, interpolation=cv2.INTER_AREA)
        return _image(
            cv2.addWeighted(averaged, 1.0 + SHARPENED, cv2.GaussianBlur(averaged, (0, 0), 1.0), -SHARPENED, 0.0)
        )

    def _eye(self, view: int, finer: int = 1) -> Eye:
        width, height = (finer * pixels for pixels in self._whole[2:])
        focal_px = height / 2 / math.tan(math.radians(self._model.cam_fovy[view]) / 2)
        turned = self._data.cam_xmat[view].reshape(3, 3) @ OPENGL_R_IMAGE
        return Eye(self._data.cam_xpos[view].copy(), turned, focal_px, width, height)

    def _draw(self, view: int, window: DrawnArea, *, room: bool, things: bool, kinds: mujoco.mjtCatBit = ALL) -> Image:
        """A window of a view as RGBA, alpha 0 where nothing is."""
        self._camera.fixedcamid = view
        self._option.geomgroup[:] = things
        self._option.geomgroup[ROOM_GROUP] = room
        mujoco.mjv_updateScene(
            self._model,
            self._data,
            self._option,
            self._perturbation,
            self._camera,
            kinds,
            self._scene,
        )
        _, _, width, height = self._whole
        for camera in self._scene.camera:
            pixel = (camera.frustum_top - camera.frustum_bottom) / height
            camera.frustum_center += (window.left + (window.width - width) / 2) * pixel
            camera.frustum_top -= window.top * pixel
            camera.frustum_bottom = camera.frustum_top - window.height * pixel
        return _image(cv2.flip(self._screen.draw(self._scene, window.width, window.height), 0))


class CellCamera:
    """One simulated view; a frame is stamped with the instant of the posture that it shows."""

    noise_free = True

    def __init__(self, name: str, renderer: CellRenderer, snapshot: SharedRecord) -> None:
        self.name = name
        self._renderer = renderer
        self._snapshot = snapshot
        self._view = renderer.view_id(name)
        renderer.prepare(self._view)
        self._frame: Frame | None = None
        self._posture: Array | None = None
        self._picture: Image = np.empty(0, dtype=np.uint8)
        self._seq = 0

    def newest(self) -> Frame | None:
        """The view of the newest posture, rendered only if it has moved; None before the cell's first step."""
        snapshot = self._snapshot.read()
        capture_ns = int(snapshot["t_ns"])
        if capture_ns > (self._frame.capture_ns if self._frame else 0):
            self._frame = Frame(self._shown(np.asarray(snapshot["qpos"], dtype=float)), capture_ns, self._seq)
            self._seq += 1
        return self._frame

    def _shown(self, posture: Array) -> Image:
        if self._posture is None or np.abs(posture - self._posture).max() > UNMOVED:
            self._posture, self._picture = posture, self._renderer.render(self._view, posture)
        return self._picture

    def close(self) -> None:
        """Release the context, which all views share."""
        self._renderer.close()


def open_cell_cameras(
    names: Sequence[str], cell: Cell, snapshot: SharedRecord, config: VideoConfig
) -> list[CellCamera]:
    """Simulated cameras by the names of their views, on one context; CameraError names what is missing."""
    renderer = CellRenderer(cell, config.width, config.height)
    return [CellCamera(name, renderer, snapshot) for name in names]


def _box_corners(boxes: Array) -> Array:
    """The corners (n, 8, 3) of boxes (n, 6), each its middle and half its size."""
    signs = np.array(list(itertools.product((-1.0, 1.0), repeat=3)))
    return np.asarray(boxes[:, None, :3] + signs * boxes[:, None, 3:], dtype=float)


def _where(rgba: Image, alpha: int) -> Image:
    return np.asarray(cv2.extractChannel(rgba, 3) == alpha).view(np.uint8)


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
