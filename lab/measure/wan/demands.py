"""Demands on each link and on each change, in one table; pure."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

from lab.measure.wan.links import Change, WanLink

Figures = Mapping[str, Any]
CAUTIOUS_MM_S = 50.0  # beyond the hand's own speed, while the arm is led back
UNSURE_MS = 20.0  # of a picture's age, beyond what the page says itself
LEAST_MBIT_S = 5.0
MS_PER_S = 1e3


@dataclass(frozen=True, slots=True)
class DemandResult:
    """One demand on one link or change: the value measured (None: not measured, or not reached), its bound."""

    where: str
    demand: str
    value: float | None
    bound: float
    passed: bool


@dataclass(frozen=True, slots=True)
class Demand:
    """A figure and its bound, which may depend on the link and on the figures of its calm sibling."""

    figure: str
    sign: str
    bound: Callable[[WanLink, Figures, Figures], float | None]
    applies: Callable[[WanLink], bool]

    def judge(self, link: WanLink, figures: Figures, calm: Figures) -> DemandResult | None:
        """None where it does not apply, or where there is nothing to compare with."""
        bound = self.bound(link, figures, calm) if self.applies(link) else None
        if bound is None:
            return None
        return verdict(link.name, self.figure, self.sign, figures.get(self.figure), bound)


def verdict(where: str, figure: str, sign: str, value: float | None, bound: float) -> DemandResult:
    """Judge whether a figure keeps its bound; one that is missing does not."""
    kept = value is not None and math.isfinite(value) and (value >= bound if sign == "≥" else value <= bound)
    return DemandResult(where, f"{figure} {sign} {bound:g}", value, bound, kept)


def constant(bound: float) -> Callable[[WanLink, Figures, Figures], float]:
    """The same bound everywhere."""
    return lambda _link, _figures, _calm: bound


def beyond_delay(ms: float) -> Callable[[WanLink, Figures, Figures], float]:
    """So much more than the link's own delay."""
    return lambda link, _figures, _calm: link.delay_ms + ms


def times(factor: float, other: float | None) -> float | None:
    """A multiple of another figure, where that was measured."""
    return None if other is None else factor * other


def wide(link: WanLink) -> bool:
    """A link on which the arm has to follow as if it were good."""
    return link.mbit_s >= LEAST_MBIT_S


def narrow(mbit_s: float) -> Callable[[WanLink], bool]:
    """The link of a rate, without loss."""
    return lambda link: link.mbit_s == mbit_s and link.loss == 0


DEMANDS = (
    Demand("followed", "≥", constant(0.995), wide),
    Demand("holds_a_minute", "≤", constant(2.0), wide),
    Demand("latches", "≤", constant(0), wide),
    Demand("changes_in_a_second", "≤", constant(2), lambda _: True),
    Demand("error_mm", "≤", lambda _, __, calm: times(1.2, calm.get("error_mm")), lambda k: wide(k) and k != k.calm),
    Demand("fps", "≥", constant(25.0), narrow(5.0)),
    Demand("age_p95_ms", "≤", beyond_delay(120.0), narrow(5.0)),
    Demand("ssim_below_jpeg", "≤", constant(0.02), narrow(5.0)),
    Demand("fps", "≥", constant(15.0), narrow(2.0)),
    Demand("age_p95_ms", "≤", beyond_delay(200.0), narrow(2.0)),
    Demand("hand_p99_ms", "≤", lambda _, own, __: times(1.3, own.get("hand_alone_p99_ms")), lambda _: True),
)


def judge_links(measured: Mapping[WanLink, Figures]) -> list[DemandResult]:
    """Every demand on every link."""
    verdicts = (
        demand.judge(link, figures, measured.get(link.calm, {}))
        for link, figures in measured.items()
        for demand in DEMANDS
    )
    return [one for one in verdicts if one is not None]


def judge_change(change: Change, figures: Figures, hand_mm_s: float) -> list[DemandResult]:
    """Every demand on a link that changed; `hand_mm_s` is the hand's greatest speed."""

    def needs(figure: str, sign: str, bound: float) -> DemandResult:
        value = figures.get(figure)
        return verdict(change.name, figure, sign, None if value is None else float(value), bound)

    always = [
        needs("followed_before", "≥", 1),
        needs("tool_mm_s", "≤", hand_mm_s + CAUTIOUS_MM_S),
        needs("age_understated_ms", "≤", UNSURE_MS),
    ]
    if change.to is not None:
        followed = needs("followed_after_s", "≤", 2.0)
        said = followed.value is None and bool(figures.get("why"))
        again = replace(followed, demand=f"{followed.demand}, or says why not", passed=followed.passed or said)
        return [*always, needs("holds", "≤", 1), again]
    if change.seconds < 1.0:
        is_outlasted = (figures.get("age_limit_before_ms") or 0.0) >= change.seconds * MS_PER_S
        held = [] if is_outlasted else [needs("held", "≥", 1)]  # else no sample need become too old
        return [*always, *held, needs("latched", "≤", 0), needs("followed_after_s", "≤", 1.0)]
    ready_s = 1.0 if change.seconds <= 1.0 else 2.0
    return [*always, needs("latched", "≥", 1), needs("ready_after_s", "≤", ready_s), needs("moved_mrad", "≤", 0)]
