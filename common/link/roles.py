"""Identities: a role at a cell, written as a certificate's common name; pure."""

import re
from dataclasses import dataclass
from enum import StrEnum


class Role(StrEnum):
    """The role of a participant at a cell; the table of channels (`channels.py`) defines what each may do."""

    REMOTE = "remote"
    OPERATOR = "operator"
    VIEWER = "viewer"
    MAINTENANCE = "maintenance"
    ROUTER = "router"


EVERYBODY = frozenset(Role) - {Role.ROUTER}  # a router only passes messages on
OPERATORS = frozenset({Role.OPERATOR})
REMOTES = frozenset({Role.REMOTE})
MAINTAINERS = frozenset({Role.MAINTENANCE})
CELL_NAME = re.compile(r"[a-z0-9][a-z0-9_-]{0,31}")
COMMON_NAME = re.compile(rf"([a-z]+)(?:\.({CELL_NAME.pattern}))?")


@dataclass(frozen=True, slots=True)
class Identity:
    """A role at a cell; `cell` is None for a router, which serves every cell of its certificate authority."""

    role: Role
    cell: str | None

    @property
    def common_name(self) -> str:
        """The certificate's common name, which access control compares literally."""
        return self.role.value if self.cell is None else f"{self.role.value}.{self.cell}"


def read_common_name(name: str) -> Identity | None:
    """The identity that a common name denotes, None if it is not one of Farhand's."""
    match = COMMON_NAME.fullmatch(name)
    if match is None or match[1] not in set(Role):
        return None
    role, cell = Role(match[1]), match[2]
    return Identity(role, cell) if (cell is None) == (role is Role.ROUTER) else None
