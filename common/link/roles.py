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
OTHERS = EVERYBODY - OPERATORS
REMOTES = frozenset({Role.REMOTE})
MAINTAINERS = frozenset({Role.MAINTENANCE})
LISTENERS = frozenset({Role.REMOTE, Role.OPERATOR, Role.ROUTER})  # the others only connect
CELL_NAME = re.compile(r"[a-z0-9][a-z0-9_-]{0,31}")
COMMON_NAME = re.compile(rf"([a-z]+)(?:\.({CELL_NAME.pattern}))?(?:\.({CELL_NAME.pattern}))?")
MAX_COMMON_NAME = 64  # of X.509 (RFC 5280, ub-common-name)


@dataclass(frozen=True, slots=True)
class Identity:
    """A role at a cell; `operator` is an operator's name, None in the other roles."""

    role: Role
    cell: str
    operator: str | None = None

    @property
    def common_name(self) -> str:
        """The certificate's common name, which access control compares literally."""
        return ".".join(part for part in (self.role.value, self.cell, self.operator) if part is not None)


def read_common_name(name: str) -> Identity | None:
    """The identity that a common name denotes, None if it is not one of Farhand's."""
    match = COMMON_NAME.fullmatch(name)
    if match is None or match[1] not in set(Role):
        return None
    role, cell, operator = Role(match[1]), match[2], match[3]
    if cell is None or (operator is None) != (role is not Role.OPERATOR):
        return None
    return Identity(role, cell, operator)
