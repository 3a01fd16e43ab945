"""A check taken out of the product for the time of a test, to show that the test notices."""

import inspect
import textwrap
from dataclasses import dataclass

import pytest


@dataclass(frozen=True)
class Mutation:
    """A function of a class, the text of a check in it, and its replacement."""

    owner: object
    function: str
    check: str
    instead: str

    def apply(self, monkeypatch: pytest.MonkeyPatch) -> None:
        """Replace the true function by the changed one; the text must be there exactly once."""
        function = getattr(self.owner, self.function)
        source = textwrap.dedent(inspect.getsource(function))
        assert source.count(self.check) == 1, f"{self.check!r} is not a check of {self.function} any more"
        names: dict[str, object] = {}
        exec(compile(source.replace(self.check, self.instead), "mutation", "exec"), function.__globals__, names)  # noqa: S102
        monkeypatch.setattr(self.owner, self.function, names[self.function])
