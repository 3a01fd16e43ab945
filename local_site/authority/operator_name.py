"""The operator's name where none is configured."""

import re
import socket

NAME_CHARACTERS = 32


def host_operator() -> str:
    """This host's name, fit to stand in a key."""
    host = socket.gethostname().partition(".")[0].lower()
    return re.sub(r"[^a-z0-9_-]", "-", host).strip("-_")[:NAME_CHARACTERS] or "operator"
