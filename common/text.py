"""Text from elsewhere, fit to be sent and shown: cut to a length, and without characters that act on a terminal."""

ELLIPSIS = "…"


def cut(text: str, most: int) -> str:
    """The text with at most `most` characters, the last an ellipsis where some are missing; always valid UTF-8."""
    shown = text if len(text) <= most else text[: most - 1] + ELLIPSIS
    return shown.encode(errors="replace").decode()


def escaped(text: str) -> str:
    r"""The text in one line, with \x1b, \n or \u202e in the place of what a terminal obeys or does not show."""
    if text.isprintable():
        return text
    return "".join(char if char.isprintable() else char.encode("unicode_escape").decode() for char in text)
