"""The parameters of the room in which the simulated operator is filmed."""

from typing import Annotated, Literal

from msgspec import Meta, Struct

SceneName = Literal["dark", "office"]
SkinName = Literal["light", "medium", "dark"]


class RoomConfig(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What is to be seen around the arm, and the arm's colours; all but `scene` counts in an office only."""

    scene: Annotated[
        SceneName, Meta(description="a grey arm before black cloth, or one in colour in an office drawn from the seed")
    ] = "dark"
    skin: Annotated[SkinName, Meta(description="tone of the operator's skin")] = "light"
