"""The parameters of the right to operate, and the operator's name where none is configured."""

import re
import socket
from typing import Annotated

import msgspec
from msgspec import Meta

from common.link.channels import check_cell_name

NAME_CHARACTERS = 32


def host_operator() -> str:
    """This host's name, with the characters that a key allows."""
    host = socket.gethostname().partition(".")[0].lower()
    return re.sub(r"[^a-z0-9_-]", "-", host).strip("-_")[:NAME_CHARACTERS] or "operator"


class AuthorityConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """How this operator obtains the right to operate the cell."""

    operator: Annotated[str, Meta(description="name shown to others at the cell; empty: this host's name")] = ""
    automatic: Annotated[bool, Meta(description="ask for the lease whenever it is free; else: farhand lease take")] = (
        True
    )

    def __post_init__(self) -> None:
        check_cell_name(self.name, "operator")

    @property
    def name(self) -> str:
        """The operator's name."""
        return self.operator or host_operator()
