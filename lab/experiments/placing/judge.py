"""Judge of a trial, by the simulation: only the figures are made of it, nobody acts on it."""

from dataclasses import dataclass

import mujoco
import numpy as np

from common.geometry import Array
from remote_site.config import RemoteConfig
from remote_site.simulation.config import BLOCK
from remote_site.simulation.process import SimulatedCell

LIFTED_M = 0.01
STANDS_RAD = np.radians(2)
NEAR_M, NEAR_RAD = 0.02, np.radians(10)
FINGERS = ("finger_left", "finger_right")
MM = 1e3


@dataclass(frozen=True, slots=True)
class Placed:
    """The block at the end: its marked corner off the target's (mm), its edges off the target's (deg).

    `placed`: it stands on the table, free of the gripper, within 20 mm and 10 deg.
    """

    x_mm: float
    y_mm: float
    angle_deg: float
    placed: bool


class Judge:
    """Watches the simulated cell: contacts, drops, and where the block is left."""

    def __init__(self, config: RemoteConfig, cell: SimulatedCell) -> None:
        self._config, self._cell = config.simulation, cell
        model = cell.cell.model
        self._block: int = model.geom(BLOCK).id
        self._fingers = {model.geom(name).id for name in FINGERS}
        self._robot = {k for k in range(model.ngeom) if model.geom_bodyid[k] and k not in self._fingers} - {self._block}
        self._touching, self._lifted = False, False
        self.collisions, self.drops, self.grip_force_n = 0, 0, 0.0

    def watch(self) -> None:
        """Take the state of now into account."""
        pairs = {frozenset(pair): k for k, pair in enumerate(self._cell.data.contact.geom.tolist())}
        robot = self._robot | self._fingers
        touching = any(pair & self._robot and not pair <= robot for pair in pairs)
        self.collisions += int(touching and not self._touching)
        self._touching = touching
        held = [k for pair, k in pairs.items() if self._block in pair and pair & self._fingers]
        self.grip_force_n = max([self.grip_force_n, *(self._force_n(k) for k in held)])
        height = self._pose[1][2] - self._config.scene.table_z_m - self._config.block.size_m[2] / 2
        if self._lifted and not held:
            self.drops += int(height > LIFTED_M)
            self._lifted = False
        elif held and height > LIFTED_M:
            self._lifted = True

    def placed(self) -> Placed:
        """Measure where the block has been left."""
        rotation, middle = self._pose
        x, y, _ = self._config.block.size_m
        corner = middle + rotation @ np.array([x / 2, -y / 2, 0.0])
        off = corner[:2] - self._config.scene.target_corner_xy_m
        angle = float(np.arctan2(rotation[1, 0], rotation[0, 0]))
        stands = np.arccos(np.clip(rotation[2, 2], -1, 1)) < STANDS_RAD and not self._lifted and not self._held()
        near = np.linalg.norm(off) < NEAR_M and abs(angle) < NEAR_RAD
        return Placed(MM * float(off[0]), MM * float(off[1]), float(np.degrees(angle)), bool(stands and near))

    @property
    def _pose(self) -> tuple[Array, Array]:
        body = self._cell.data.body(BLOCK)
        return body.xmat.reshape(3, 3), body.xpos

    def _held(self) -> bool:
        contacts = self._cell.data.contact
        return any(self._block in (c.geom1, c.geom2) and {c.geom1, c.geom2} & self._fingers for c in contacts)

    def _force_n(self, contact: int) -> float:
        force = np.zeros(6)
        mujoco.mj_contactForce(self._cell.cell.model, self._cell.data, contact, force)
        return float(np.linalg.norm(force[:3]))
