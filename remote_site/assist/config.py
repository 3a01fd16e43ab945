"""The targets of fine adjustment: markers in the cell, and where the tool belongs beside them."""

import math
from typing import Annotated, Literal

import msgspec
from msgspec import Meta

from common.geometry import Array
from common.messages.base import Name
from remote_site.assist.families import MarkerFamily
from remote_site.assist.placement import Row3, transform_of


class AssistTargetConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A pose of the tool beside a marker; the marker's frame has x to its right, y up and z towards who looks at it."""

    name: Annotated[Name, Meta(description="as the operator's page names it")]
    marker: Annotated[int, Meta(ge=0, description="the marker's number in its family")]
    size_mm: Annotated[float, Meta(ge=10, le=500, description="side of its black square, mm")]
    kind: Annotated[Literal["grasp", "place"], Meta(description="what the tool does there")]
    xyz_mm: Annotated[Row3, Meta(description="the tool centre point in the marker's frame, mm")]
    rpy_deg: Annotated[
        Row3, Meta(description="the tool's axes in the marker's frame: turned about its x, then y, then z, deg")
    ]

    def __post_init__(self) -> None:
        if not all(math.isfinite(v) for v in (*self.xyz_mm, *self.rpy_deg)):
            raise ValueError(f"target {self.name!r}: xyz_mm and rpy_deg must be finite numbers")

    @property
    def size_m(self) -> float:
        """The side of the black square, m."""
        return 1e-3 * self.size_mm

    @property
    def marker_T_tool(self) -> Array:
        """The tool's pose (4 x 4) in the marker's frame."""
        return transform_of(self.xyz_mm, self.rpy_deg)


class AssistConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Fine adjustment by the robot, which the operator asks for; off unless targets are named."""

    family: Annotated[MarkerFamily, Meta(description="of all markers")] = MarkerFamily.ARUCO_4X4_50
    reach_mm: Annotated[float, Meta(gt=0, le=150, description="a target farther from the tool is not offered, mm")] = (
        60.0
    )
    targets: Annotated[tuple[AssistTargetConfig, ...], Meta(max_length=16)] = ()

    def __post_init__(self) -> None:
        names = [target.name for target in self.targets]
        sizes: dict[int, float] = {}
        for target in self.targets:
            if names.count(target.name) > 1:
                raise ValueError(f"two targets are named {target.name!r}: give each a name of its own")
            if target.marker >= self.family.size:
                most = self.family.size - 1
                raise ValueError(f"target {target.name!r}: {self.family} has markers 0 to {most}, not {target.marker}")
            if sizes.setdefault(target.marker, target.size_mm) != target.size_mm:
                raise ValueError(f"marker {target.marker} has two sizes: give all of its targets the same size_mm")

    @property
    def marker_sizes_m(self) -> dict[int, float]:
        """The side in m of each marker that a target names."""
        return {target.marker: target.size_m for target in self.targets}
