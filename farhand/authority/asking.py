"""A link to the sites that a command asks something of."""

from collections.abc import Iterator
from contextlib import contextmanager

from common.errors import RefusedError, TransportError
from common.link.channels import check_cell_name
from common.link.config import LinkSecurity
from common.link.transport import Link, open_link


@contextmanager
def link_to(cell: str, *endpoints: str, security: LinkSecurity) -> Iterator[Link]:
    """A link to sites; without an answer, the TransportError gives the reason if one can be found."""
    check_cell_name(cell)
    with open_link(connect=endpoints, security=security) as link:
        try:
            yield link
        except RefusedError:
            raise
        except TransportError as error:
            link.check_connected()
            if why := link.why_silent():
                raise TransportError(f"{error} {why}") from error
            raise
