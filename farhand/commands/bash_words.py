"""What bash asks to complete and is answered, with the words that it splits at = and : put together again."""

import io
import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, redirect_stdout

ASKED, ASKED_BY_BASH = "_FARHAND_COMPLETE", "complete_bash"
WORDS, AT = "COMP_WORDS", "COMP_CWORD"  # as the script that --install-completion writes hands them on
BREAKS = "=:"  # of bash's COMP_WORDBREAKS, those that stand within the command line's words
ANY_VALUE = "VALUE"


@contextmanager
def whole_words() -> Iterator[None]:
    """Let what answers a shell see whole words, where bash asks, and bash the parts that it takes in their place."""
    if os.environ.get(ASKED) != ASKED_BY_BASH:
        yield
        return
    words, kept = joined(os.environ[WORDS].split("\n")[: int(os.environ[AT]) + 1])
    os.environ |= {WORDS: "\n".join(words), AT: str(len(words) - 1)}
    answer = io.StringIO()
    try:
        with redirect_stdout(answer):
            yield
    finally:
        print("\n".join(replies(answer.getvalue().splitlines(), kept)))  # noqa: T201  # what the shell reads


def joined(parts: Sequence[str]) -> tuple[list[str], str]:
    """The words whose parts these are, up to the one to complete, and how much of that one bash leaves as it is."""
    words: list[str] = []
    kept, is_open = "", False
    for part in parts:
        is_break = bool(part) and not part.strip(BREAKS)
        if words and part and (is_break or is_open):
            kept = words[-1] + (part if is_break else "")
            words[-1] += part
        else:
            words.append(part)
            kept = ""
        is_open = is_break
    return words, kept


def replies(answers: Sequence[str], kept: str) -> list[str]:
    """What bash puts in the place of the last part, `kept` before it; it puts a space behind a sole reply.

    Behind a key there belongs none, so that is given twice, once with a value.
    """
    if kept.startswith("-"):  # --option=: what answers leaves that out itself
        kept = kept.partition("=")[2]
    if len(answers) == 1 and answers[0].endswith("="):
        answers = [*answers, answers[0] + ANY_VALUE]
    return [answer.removeprefix(kept) for answer in answers]
