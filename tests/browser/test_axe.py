"""axe finds nothing to complain of, in any state, dark or light, at any width."""

from importlib.resources import files
from typing import Any

import pytest

from lab.measure.page.bare_console import BareConsole
from lab.measure.page.screenshots import STATES
from tests.browser.many_views import FULL, show_views
from tests.browser.told import Told, opened_told

AXE = "axe_playwright_python"
RUN = "async () => (await axe.run()).violations.map((v) => [v.id, v.help, v.nodes.map((n) => n.html.slice(0, 120))])"
SCREENS = {"dark": (1280, 720), "light": (820, 1180)}
SIZES = ((390, 844), (820, 1180), (1280, 720), (1920, 1080), (2560, 1440))
FOLDS = ("#settings", "#facts", "#latency-room", "#events-room", "#keys")
WORDS = {"ready": "disengaged", "limited": "engaged", "another operates": "berta operates"}


@pytest.fixture(scope="module")
def axe() -> str:
    """The script of axe; skips where it is not installed."""
    pytest.importorskip(AXE, reason="no axe; pip install -e '.[dev]'")
    return files(AXE).joinpath("axe.min.js").read_text(encoding="utf-8")


def violations(told: Told, script: str) -> list[Any]:
    page = told.page.page
    if not page.evaluate("() => 'axe' in window"):
        page.evaluate(f"() => {{ {script} }}")
    return list(page.evaluate(RUN))


@pytest.mark.slow
@pytest.mark.parametrize("name", [name for name in STATES if name != "no robot"])
def test_axe_finds_nothing(told: Told, axe: str, name: str) -> None:
    page = told.page.page
    told.state = STATES[name]
    told.until("the word", lambda: told.page.state() == WORDS.get(name, name))
    for fold in FOLDS:
        page.evaluate("(fold) => { document.querySelector(fold).open = true; }", fold)
    for theme, (width, height) in SCREENS.items():
        told.page.wear(theme)
        told.page.resize(width, height)
        assert violations(told, axe) == []
    told.page.wear("dark")
    told.page.resize(1280, 720)


def test_axe_finds_nothing_without_a_connection(told: Told, axe: str) -> None:
    told.until("a state", lambda: told.page.state() == "engaged")
    told.page.wait_for("silence", lambda: told.page.state() == "no connection" or told.page.state() == "silent")
    assert violations(told, axe) == []


@pytest.mark.slow
def test_axe_finds_nothing_before_anything_was_started_nor_among_the_keys(browser: object, axe: str) -> None:
    with BareConsole() as console:
        page = browser.new_context().new_page()  # type: ignore[attr-defined]  # not touched: it is shown the keys
        page.goto(console.address)
        page.wait_for_selector("#no-views code")
        page.evaluate("() => { document.getElementById('keys').open = true; }")
        page.evaluate(f"() => {{ {axe} }}")
        assert page.evaluate(RUN) == []
        page.context.close()


def test_axe_would_complain_of_a_button_without_a_name(told: Told, axe: str) -> None:
    page = told.page.page
    page.evaluate("() => document.getElementById('side').append(document.createElement('button'))")
    found = violations(told, axe)
    page.evaluate("() => document.getElementById('side').lastElementChild.remove()")
    assert "button-name" in [name for name, *_ in found]


@pytest.mark.long
@pytest.mark.parametrize("count", range(1, 9))
def test_axe_finds_nothing_with_any_number_of_views_at_any_width(browser: object, axe: str, count: int) -> None:
    with opened_told(browser) as told:
        show_views(told, [FULL] * count)
        for theme in ("dark", "light"):
            told.page.wear(theme)
            for width, height in SIZES:
                told.page.resize(width, height)
                assert violations(told, axe) == [], (width, theme)
