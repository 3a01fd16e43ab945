"""Plan of a live trial's processes: the same cell, tracker and operator as in lockstep; pure."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from common.clock import NS_PER_S
from lab.experiments.placing.trial import MOST_S, PAGE_NS, WRIST_M, Conditions, remote_config
from lab.stage.cell_endpoints import CellEndpoints
from lab.visual_operator.at_console.operator_process import OperatorSetup

CELL, OPERATOR_NAME = "placing", "visual_operator"


@dataclass(frozen=True, slots=True)
class LivePlan:
    """The settings of each process, and what the operator's gets; the endpoints of both sites for who records them."""

    remote: Sequence[str]
    local: Sequence[str]
    console: Sequence[str]
    operator: OperatorSetup
    control: str
    listen: str


def live_plan(conditions: Conditions, ports: Sequence[int], folder: Path) -> LivePlan:
    """A trial on four free ports of this host, with hand and notes of the operator in this folder."""
    control, video, listen, page = ports
    endpoints = CellEndpoints.on_ports(CELL, control, video, listen)
    hand = folder / "hand"
    return LivePlan(
        remote=(*endpoints.remote, *_remote_settings(conditions)),
        local=(*endpoints.local, *_local_settings(conditions)),
        console=(*endpoints.console, f"operator={OPERATOR_NAME}", f"serve.port={page}"),
        operator=OperatorSetup(
            port=page,
            led_by=str(hand),
            notes=str(folder / "notes.json"),
            roll_fixed=conditions.roll_fixed,
            seed=conditions.seed,
            page_ns=PAGE_NS,
            most_s=MOST_S,
        ),
        control=endpoints.control,
        listen=endpoints.listen,
    )


def _remote_settings(conditions: Conditions) -> Sequence[str]:
    """The cell that the stepped trial of the same seed has."""
    config = remote_config(np.random.default_rng(conditions.seed))
    block = config.simulation.block
    x, y = block.centre_xy_m
    return (
        f"engagement.mode={config.engagement.mode}",
        f"video.calibrated={str(config.video.calibrated).lower()}",
        f"video.fps={NS_PER_S / PAGE_NS}",
        f"simulation.block.centre_xy_m=[{x!r}, {y!r}]",
        f"simulation.block.yaw_deg={block.yaw_deg!r}",
    )


def _local_settings(conditions: Conditions) -> Sequence[str]:
    """The operator's arm that the stepped trial of the same seed has."""
    return (
        f"authority.operator={OPERATOR_NAME}",
        f"tracking.method={conditions.method}",
        "simulation.motion.begins=at_once",
        "simulation.motion.still_s=0",
        f"simulation.motion.wrist={list(WRIST_M)}",
        f"simulation.markers={str(conditions.method == 'markers').lower()}",
        f"simulation.seed={conditions.seed}",
    )
