"""The parameters of the room in which the simulated operator is filmed."""

from typing import Annotated, Literal

from msgspec import Meta, Struct

SceneName = Literal["dark", "office"]
SleeveName = Literal["short", "long"]
DisturbanceName = Literal["second_arm", "face", "hand_poster", "wood", "fan", "shadows"]
SkinName = Literal["light", "medium", "dark"]


class RoomConfig(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What is to be seen around the arm, and the arm's colours; all but `scene` counts in an office only."""

    scene: Annotated[
        SceneName, Meta(description="a grey arm before black cloth, or one in colour in an office drawn from the seed")
    ] = "dark"
    skin: Annotated[SkinName, Meta(description="tone of the operator's skin")] = "light"
    sleeve: Annotated[SleeveName, Meta(description="a long one leaves only the hand bare")] = "short"
    watch: Annotated[bool, Meta(description="a watch at the wrist")] = False
    empty_s: Annotated[
        float, Meta(ge=0, le=60, description="how long the cameras film the empty room before the operator comes in, s")
    ] = 0.0
    disturbances: Annotated[
        tuple[DisturbanceName, ...],
        Meta(
            description="what else is to be seen: second_arm (a left one, bare), face (a person in the background), "
            "hand_poster, wood (of skin's colour), fan (it turns), shadows (they move)"
        ),
    ] = ()
