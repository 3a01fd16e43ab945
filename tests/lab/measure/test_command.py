"""`python -m bench`: words that it does not know measure nothing."""

from collections.abc import Callable

import pytest

from lab.measure import command


class Measured(list[str]):
    """The names of the benchmarks that were measured."""

    def benchmark(self, name: str) -> Callable[[], dict[str, float]]:
        """One that only notes that it was measured."""

        def measure() -> dict[str, float]:
            self.append(name)
            return {}

        return measure


@pytest.fixture(autouse=True)
def measured(monkeypatch: pytest.MonkeyPatch) -> Measured:
    names = Measured()
    for name in command.BENCHMARKS:
        monkeypatch.setitem(command.BENCHMARKS, name, names.benchmark(name))
    return names


@pytest.mark.parametrize("word", ["-h", "--help"])
def test_help_is_shown_and_nothing_measured(word: str, measured: Measured, capsys: pytest.CaptureFixture[str]) -> None:
    command.main(["wan", word])
    assert "--full has wan take the whole matrix" in capsys.readouterr().out
    assert measured == []


@pytest.mark.parametrize("words", [["--fulll"], ["cells", "-x"], ["cell"]])
def test_a_word_that_is_not_known_is_refused_and_nothing_measured(words: list[str], measured: Measured) -> None:
    with pytest.raises(SystemExit, match=r"no such (option|benchmark)"):
        command.main(words)
    assert measured == []
