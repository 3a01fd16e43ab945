"""A person for tests: answers by the words of the question, and remembers all that was told."""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager

from farhand.terminal import ShowProgress


class ScriptedPerson:
    """Gives the default, or what the script has for the first of its words that is in a question.

    A list of answers is used up one by one, then the default counts; an exception among them is raised.
    """

    def __init__(self, script: Mapping[str, str | list[str | BaseException]] | None = None) -> None:
        self._script = {key: value if isinstance(value, str) else list(value) for key, value in (script or {}).items()}
        self.told: list[str] = []
        self.shown: list[str] = []
        self.asked: list[str] = []

    def tell(self, sentence: str) -> None:
        self.told.append(sentence)

    def show(self, line: str) -> None:
        self.shown.append(line)

    def ask(self, question: str, default: str) -> str:
        self.asked.append(question)
        for words, answer in self._script.items():
            if words in question:
                return self._next(answer, default)
        return default

    def heard(self, words: str) -> bool:
        """Whether a sentence with these words was told."""
        return any(words in sentence for sentence in self.told)

    @staticmethod
    def _next(answer: str | list[str | BaseException], default: str) -> str:
        if isinstance(answer, str):
            return answer
        given = answer.pop(0) if answer else default
        if isinstance(given, BaseException):
            raise given
        return given


@contextmanager
def no_bar() -> Iterator[ShowProgress]:
    """Progress that nobody watches."""

    def show(_what: str, _done: int, _total: int | None) -> None:
        """Nothing is shown."""

    yield show
