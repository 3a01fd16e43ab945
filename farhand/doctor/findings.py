"""Findings of a check: severity, a sentence, the cure; as text for people and as JSON for programs."""

from collections.abc import Sequence
from enum import StrEnum
from typing import Any

import msgspec

from common.text import escaped


class Severity(StrEnum):
    """The severity of a finding: with an error Farhand cannot run, with a warning it runs worse than it could."""

    OK = "ok"
    WARNING = "warning"
    ERROR = "error"


class Finding(msgspec.Struct, frozen=True):
    """The result of one check; `cure` is empty where there is nothing to do."""

    check: str
    level: Severity
    sentence: str
    cure: str = ""


def ok(check: str, sentence: str) -> Finding:
    """All is well."""
    return Finding(check, Severity.OK, sentence)


def warning(check: str, sentence: str, cure: str) -> Finding:
    """It runs, but worse than it could."""
    return Finding(check, Severity.WARNING, sentence, cure)


def error(check: str, sentence: str, cure: str) -> Finding:
    """It cannot run."""
    return Finding(check, Severity.ERROR, sentence, cure)


def worst(findings: Sequence[Finding]) -> Severity:
    """The worst level among them."""
    order = list(Severity)
    return max((finding.level for finding in findings), key=order.index, default=Severity.OK)


def as_text(findings: Sequence[Finding]) -> str:
    """A line per finding, its cure below, and a closing line that counts."""
    lines = []
    for finding in findings:
        lines.append(f"{finding.level.value:<8} {finding.check}: {finding.sentence}")
        if finding.cure:
            lines.append(f"{'':<8}   cure: {finding.cure}")
    counts = {level: sum(finding.level is level for finding in findings) for level in Severity}
    lines.append(", ".join(f"{count} {level.value}" for level, count in counts.items()))
    return "\n".join(map(escaped, lines))


def as_builtins(findings: Sequence[Finding]) -> dict[str, Any]:
    """The worst level and every finding, for programs."""
    return {"worst": worst(findings), "findings": list(findings)}
