"""A camera's source as people may see it: of a stream the scheme and host alone, since the rest may hold a password."""

import re

HOST = re.compile(r"(?:[^@/?#]*@)?([A-Za-z0-9._-]+|\[[0-9a-fA-F:.]+\])(:\d+)?(?=[/?#]|$)")
HIDDEN = "..."


def shown_source(source: int | str) -> str:
    """The source without user, password, path and query where it is a URL; all else as it is."""
    scheme, is_url, rest = str(source).partition("://")
    if not is_url:
        before, has_user, _ = str(source).rpartition("@")
        return HIDDEN if has_user and ":" in before else str(source)  # a URL that lacks a slash
    host = HOST.match(rest)
    # A second "@" may stand in a password that was not escaped, so that nobody knows where the host begins.
    if host is None or rest.count("@") > host[0].count("@"):
        return f"{scheme}://{HIDDEN}"
    return f"{scheme}://{host[1]}{host[2] or ''}"


def hides_part(source: int | str) -> bool:
    """Return whether a source has a part that is not shown, since it may hold a password."""
    return shown_source(source) != str(source)
