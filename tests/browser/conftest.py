"""Both sites with small pictures, a console, a browser and an operating page, once for all tests of a file."""

import shutil
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import pytest

from farhand.loopback.site_process import SiteProcess, free_ports
from lab.measure.page.chromium import CHROMIUM, QUIET
from tests.browser.opened_page import OpenedPage
from tests.browser.told import Told, opened_told
from tests.integration.sites import (
    PATIENT,
    Sites,
    pytest_runtest_makereport,
    running_sites,
)

__all__ = ["pytest_runtest_makereport"]

H264 = ("video.codec=h264",)  # JPEG is what the pages of told sites show
HELD = ("engagement.mode=hold_to_run", "engagement.frames=5")


@dataclass
class Stand:
    """The sites, the console's process and the address of its page, and the browser."""

    sites: Sites
    remote: SiteProcess
    console: SiteProcess
    address: str
    browser: object


@pytest.fixture(scope="session")
def browser() -> Iterator[object]:
    """Debian's chromium, without a window; skips where there is none."""
    if shutil.which(CHROMIUM) is None:
        pytest.skip("no chromium to open the page in; on Debian: apt-get install chromium")
    playwright = pytest.importorskip("playwright.sync_api", reason="no playwright; pip install -e '.[dev]'")
    with playwright.sync_playwright() as running:
        chromium = running.chromium.launch(executable_path=CHROMIUM, args=list(QUIET))
        yield chromium
        chromium.close()


@pytest.fixture(scope="module")
def stand(browser: object) -> Iterator[Stand]:
    """Both sites and a console, running."""
    with running_sites() as sites:
        settings = "driver.name=kinematic", "video.nice=0", *H264, *HELD, *PATIENT
        remote = sites.remote(*settings, program="lab.stage.stand_ins.clocked_views")
        sites.local()
        port = free_ports(1)[0]
        console = sites.start("console", *sites.endpoints.console, f"serve.port={port}")
        sites.wait_for_states()
        sites.wait("the lease", lambda: sites.state.lease is not None)
        yield Stand(sites, remote, console, f"http://127.0.0.1:{port}/", browser)


@pytest.fixture(scope="module")
def operating_page(stand: Stand) -> Iterator[OpenedPage]:
    """The page that operates, opened once, since opening one is what takes longest."""
    opened = OpenedPage(stand.browser, stand.address)
    opened.wait_for("the controls", lambda: "you operate" in opened.words("#seat"))
    yield opened
    opened.close()


@pytest.fixture
def page(operating_page: OpenedPage) -> Iterator[OpenedPage]:
    """The operating page, with nothing held or stopped; it may not have had an error."""
    operating_page.settle()
    yield operating_page
    operating_page.page.keyboard.up("Space")
    assert not operating_page.errors


@pytest.fixture(scope="session")
def told_page(browser: object) -> Iterator[Told]:
    """A page of a console without sites."""
    with opened_told(browser) as told:
        yield told


@pytest.fixture
def told(told_page: Told) -> Told:
    """The page, with a faultless state reported."""
    told_page.reset()
    return told_page


@pytest.fixture
def open_page(stand: Stand) -> Iterator[Callable[[], OpenedPage]]:
    """Opens further pages, and closes them at the end."""
    opened: list[OpenedPage] = []

    def open_one() -> OpenedPage:
        opened.append(OpenedPage(stand.browser, stand.address))
        return opened[-1]

    yield open_one
    for page in opened:
        page.close()
