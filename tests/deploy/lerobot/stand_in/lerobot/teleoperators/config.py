"""LeRobot's configuration of teleoperators: a registry of types, with these two fields in each."""

import abc
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar, TypeVar

C = TypeVar("C", bound=type)


@dataclass(kw_only=True)
class TeleoperatorConfig(abc.ABC):  # noqa: B024  # as LeRobot's
    """What every teleoperator is configured with."""

    choices: ClassVar[dict[str, type]] = {}
    id: str | None = None
    calibration_dir: Path | None = None

    @classmethod
    def register_subclass(cls, name: str) -> Callable[[C], C]:
        """Register a type of teleoperator."""

        def register(subclass: C) -> C:
            cls.choices[name] = subclass
            return subclass

        return register
