"""Where results go: never over what they are made from."""

from collections.abc import Iterable
from pathlib import Path

from common.errors import ConfigError


def refuse_inputs(out: Path, inputs: Iterable[str | Path]) -> None:
    """ConfigError if a result would be written over one of the files that it comes from."""
    for given in inputs:
        if out.exists() and Path(given).exists() and out.samefile(given):
            raise ConfigError(f"--out {out} would overwrite what is read; choose another name")
