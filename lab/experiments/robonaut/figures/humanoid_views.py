"""The humanoid in its postures, seen from the front and from its right, as in figure 8 of the ROBONAUT report."""

from collections.abc import Mapping

from common.cameras.camera import Image
from common.geometry import Array
from farhand.reports.plate import plate
from remote_site.config import RemoteConfig
from remote_site.simulation.cell import build_cell
from remote_site.video.cell_cameras import CellRenderer

VIEWS = ("coronal", "sagittal")
SIZE_PX, TILE_PX = (480, 480), 320


class HumanoidViews:
    """Renders the cell of the humanoid in any posture of the arm; CameraError with the cure where EGL is missing."""

    def __init__(self, remote: RemoteConfig) -> None:
        self._cell = build_cell(remote.simulation, remote.robot, dressed=True)
        self._at_rest = self._cell.start().qpos.copy()
        self._renderer = CellRenderer(self._cell, *SIZE_PX)

    def plate(self, postures: Mapping[int, Array]) -> bytes:
        """The PNG of postures (n,) in rad by number of frame: the coronal views above the sagittal ones."""
        tiles = [(f"frame {k}, {view}", self._picture(view, q)) for view in VIEWS for k, q in postures.items()]
        return plate(tiles, len(postures), TILE_PX)

    def close(self) -> None:
        """Release what the graphics hold; further calls do nothing."""
        self._renderer.close()

    def _picture(self, view: str, q: Array) -> Image:
        qpos = self._at_rest.copy()
        qpos[self._cell.arm] = q
        return self._renderer.render(self._renderer.view_id(view), qpos)
