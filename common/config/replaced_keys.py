"""The configuration keys of earlier releases that are gone, and what stands in the place of each."""

from collections.abc import Mapping
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Replacement:
    """The key that took the place of another, and how the old value becomes the new one."""

    key: str
    how: str

    @property
    def sentence(self) -> str:
        """The words after the old key: what replaces it, and the cure."""
        return f"is replaced by {self.key}: {self.how}"


SAME_SIGMA = "give it the same value; it is the sigma of the point that the tool copies"
ANGLE = "it is an angle in deg, not a length; leave it out for the default"

REPLACED_KEYS: Mapping[str, Replacement] = {
    "engagement.automatic": Replacement("engagement.mode", 'write "automatic" for true, "on_request" for false'),
    "safety.certainty.wrist_sure_mm": Replacement("safety.certainty.position_sure_mm", SAME_SIGMA),
    "safety.certainty.wrist_poor_mm": Replacement("safety.certainty.position_poor_mm", SAME_SIGMA),
    "safety.certainty.tips_sure_mm": Replacement("safety.certainty.turn_sure_deg", ANGLE),
    "safety.certainty.tips_poor_mm": Replacement("safety.certainty.turn_poor_deg", ANGLE),
    "drift.start_px": Replacement(
        "drift.misfit_sigmas", "it counts sigmas of the wrist, not px; leave it out for the default"
    ),
    "cells": Replacement("cell", "a router serves one cell; each further cell needs a router of its own"),
}

# Keys that nothing replaces, and the cure; a recording whose configuration has one is read without it.
GONE_KEYS: Mapping[str, str] = {
    "video.clock": "is gone: only the views of a benchmark show a clock; leave it out",
}
