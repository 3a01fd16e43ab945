"""Shows in the simulated views an arm that is not simulated: its measured joints in an otherwise untouched cell."""

import numpy as np

from common.geometry import Array
from remote_site.shared_record import SharedRecord
from remote_site.simulation.config import CellConfig
from remote_site.simulation.memory import FINGERS

UPRIGHT = (1.0, 0.0, 0.0, 0.0)  # MuJoCo's quaternions begin with the real part


class PostureMirror:
    """Writes the snapshot that the views are rendered from; fingers open, the block where it stands at the start."""

    def __init__(self, config: CellConfig, snapshot: SharedRecord) -> None:
        self._snapshot = snapshot
        self._record = np.zeros((), dtype=snapshot.dtype)
        x, y = config.block.centre_xy_m
        z = config.scene.table_z_m + config.block.size_m[2] / 2
        self._rest = np.array([*(0.0,) * FINGERS, x, y, z, *UPRIGHT])

    def show(self, t_ns: int, q: Array) -> None:
        """Show the arm at `q` (n,) rad as measured at `t_ns`."""
        self._record["t_ns"] = t_ns
        self._record["qpos"] = np.concatenate([q, self._rest])
        self._snapshot.write(self._record)
