"""An arm as makers publish theirs: meshes in a package, fingers, visuals that MuJoCo cannot read, much left unsaid."""

import struct
from itertools import pairwise
from pathlib import Path

import numpy as np

from common.geometry import Array

PACKAGE = "maker_description"
LINKS = {  # half the size of a box, and its middle, m; the joint on the link before: origin, axis, effort
    "base_link": ((0.07, 0.07, 0.03), (0.0, 0.0, 0.03), None),
    "shoulder": ((0.05, 0.05, 0.04), (0.0, 0.0, 0.0), ("0 0 0.16", "0 0 1", 150)),
    "upper": ((0.05, 0.045, 0.22), (0.0, 0.0, 0.21), ("0 0.13 0", "0 1 0", 150)),
    "fore": ((0.04, 0.04, 0.18), (0.0, 0.0, 0.20), ("0 -0.115 0.420", "0 1 0", 150)),
    "wrist_a": ((0.035, 0.035, 0.035), (0.0, 0.06, 0.0), ("0 0 0.390", "0 1 0", 28)),
    "wrist_b": ((0.03, 0.03, 0.03), (0.0, 0.0, 0.05), ("0 0.095 0", "0 0 1", 28)),
    "wrist_c": ((0.03, 0.02, 0.03), (0.0, 0.055, 0.0), ("0 0 0.095", "0 1 0", 28)),
}
FINGER = '<collision><origin xyz="0 0 0.03"/><geometry><box size="0.02 0.01 0.06"/></geometry></collision>'
FINGERS = f"""
  <joint name="hand_fixed" type="fixed"><parent link="wrist_c"/><child link="hand"/>
    <origin xyz="0 0.085 0" rpy="-1.5708 0 0"/></joint>
  <link name="hand"><collision><origin xyz="0 0 0.03"/>
    <geometry><box size="0.05 0.12 0.06"/></geometry></collision></link>
  <joint name="finger_left_joint" type="prismatic"><parent link="hand"/><child link="finger_left"/>
    <origin xyz="0 0 0.06"/><axis xyz="0 1 0"/><limit lower="0.01" upper="0.04" velocity="0.2" effort="20"/></joint>
  <link name="finger_left">{FINGER}</link>
  <joint name="finger_right_joint" type="prismatic"><parent link="hand"/><child link="finger_right"/>
    <origin xyz="0 0 0.06"/><axis xyz="0 -1 0"/><limit lower="0" upper="0.04" velocity="0.2" effort="20"/>
    <mimic joint="finger_left_joint"/></joint>
  <link name="finger_right">{FINGER}</link>
  <joint name="tcp_fixed" type="fixed"><parent link="hand"/><child link="hand_tcp"/><origin xyz="0 0 0.11"/></joint>
  <link name="hand_tcp"/>"""
FLANGE = """
  <joint name="flange_fixed" type="fixed"><parent link="wrist_c"/><child link="tool0"/>
    <origin xyz="0 0.085 0" rpy="-1.5708 0 0"/></joint>
  <link name="tool0"/>"""


def unseen(what: str, done: int, total: int | None) -> None:
    """Show no progress."""


def publish(folder: Path, *, end: str = FINGERS) -> Path:
    """The URDF of a six-axis arm in a package of this folder, its collision meshes beside it."""
    package = folder / PACKAGE
    (package / "meshes").mkdir(parents=True)
    (package / "urdf").mkdir()
    for name, (half, middle, _) in LINKS.items():
        (package / "meshes" / f"{name}.stl").write_bytes(box_stl(half, middle))
        (package / "meshes" / f"{name}.dae").write_text("<COLLADA/>")
    urdf = package / "urdf" / "arm.urdf"
    urdf.write_text(f'<robot name="published">{"".join(map(_link, LINKS))}{"".join(_joints())}{end}</robot>')
    return urdf


def _link(name: str) -> str:
    meshes = {kind: f"package://{PACKAGE}/meshes/{name}.{ending}" for kind, ending in _ENDINGS.items()}
    shapes = (f'<{k}><geometry><mesh filename="{file}"/></geometry></{k}>' for k, file in meshes.items())
    return f'<link name="{name}">{"".join(shapes)}</link>'


_ENDINGS = {"visual": "dae", "collision": "stl"}


def _joints() -> list[str]:
    joints = []
    for parent, child in pairwise(LINKS):
        origin, axis, effort = LINKS[child][2] or ("", "", 0)
        joints.append(
            f'<joint name="{child}_joint" type="revolute"><parent link="{parent}"/><child link="{child}"/>'
            f'<origin xyz="{origin}"/><axis xyz="{axis}"/>'
            f'<limit lower="-6.2" upper="6.2" velocity="3.1" effort="{effort}"/></joint>'
        )
    return joints


def box_triangles(half: tuple[float, float, float], middle: tuple[float, float, float]) -> Array:
    """The twelve triangles (12 x 3 x 3) of a box."""
    triangles = []
    for axis in range(3):
        u, v = np.eye(3)[(axis + 1) % 3], np.eye(3)[(axis + 2) % 3]
        for side in (-1.0, 1.0):
            a, b, c, d = (side * np.eye(3)[axis] + x * u + y * v for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1)))
            triangles += [(a, b, c), (a, c, d)]
    placed: Array = np.array(triangles) * np.array(half) + np.array(middle)
    return placed


def box_stl(half: tuple[float, float, float], middle: tuple[float, float, float]) -> bytes:
    """The same as a binary STL file."""
    triangles = box_triangles(half, middle)
    records = (struct.pack("<12fH", 0, 0, 0, *triangle.ravel(), 0) for triangle in triangles)
    return bytes(80) + struct.pack("<I", len(triangles)) + b"".join(records)
