"""A value of the wrong type is answered in plain words with what to write instead."""

from typing import Annotated, Any, Literal

import pytest
from msgspec import Meta, Struct

from common.config.loading import load_config
from common.errors import ConfigError

Metres = Annotated[float, Meta(gt=0, le=5, description="reach, m")]


class Shelf(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    reach_m: Metres = 1.0
    count: int = 1
    open: bool = True
    name: Annotated[str, Meta(max_length=4)] = ""
    title: Annotated[str, Meta(min_length=1)] = "a"
    size: tuple[float, float, float] = (0.0, 0.0, 0.0)
    rows: Annotated[tuple[tuple[float, float], ...], Meta(min_length=1)] = ((0.0, 0.0),)
    by_name: dict[str, float] = {}  # msgspec copies it
    mass_kg: float | None = None
    jerk: float | Literal["own"] = "own"


@pytest.mark.parametrize(
    ("setting", "cure"),
    [
        ("reach_m=far", "'far' is not allowed: give a number, not words in quotes (reach, m)"),
        ("reach_m='0.5'", "'0.5' is not allowed: write it without quotes: 0.5"),
        ("reach_m=9", "9 is not allowed: give a number <= 5.0 (reach, m)"),
        ("count=1.5", "1.5 is not allowed: give a whole number, not a number"),
        ("open=yes", "'yes' is not allowed: give true or false, not words in quotes"),
        ("open='true'", "'true' is not allowed: write it without quotes: true"),
        ("name=7", "7 is not allowed: give words in quotes, not a whole number"),
        ("title=''", "'' is not allowed: give words of at least 1 character"),
        ("name=shelf", "'shelf' is not allowed: give words of at most 4 characters"),
        ("size=[1, 2]", "[1, 2] is not allowed: give a list of 3, not of 2"),
        ("size=[1, 'a', 2]", "give a number as number 2 of the list, not words in quotes"),
        ("size=1", "1 is not allowed: give a list in brackets, not a whole number"),
        ("rows=[]", "[] is not allowed: give a list of at least 1"),
        ("rows=[[1, 2], [3]]", "give a list of 2 as number 2 of the list, not of 1"),
        ("by_name={a='b'}", "give a number, not words in quotes"),
        ("mass_kg=heavy", "'heavy' is not allowed: give a number, not words in quotes"),
        ("jerk=[1]", "[1] is not allowed: "),
    ],
)
def test_a_wrong_value_is_told_with_its_cure(setting: str, cure: str) -> None:
    with pytest.raises(ConfigError) as wrong:
        load_config(Shelf, None, [setting])
    assert cure in str(wrong.value)
    assert not {"Expected", "`float`", "`str`", "$["} & set(str(wrong.value).split())


def test_words_of_another_kind_stay_as_they_are() -> None:
    from common.config.type_words import in_plain_words

    said: Any = "is missing"
    assert in_plain_words(said, 1) == said
