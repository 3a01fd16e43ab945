"""What `farhand driver list` says of the drivers that are installed, whatever they do when they are loaded."""

import sys
from collections.abc import Callable, Iterator
from importlib.metadata import EntryPoint, PathDistribution
from pathlib import Path

import pytest

from remote_site.drivers import listing
from remote_site.drivers.listing import ListedDriver, list_drivers
from remote_site.drivers.registry import GROUP

MODULE = '''
import sys

def described(host):
    """A robot of this test.

    More about it.
    """

def silent(host): ...

answer = 42
'''


@pytest.fixture
def package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[..., EntryPoint]]:
    """Makes an entry point of an installed package with these drivers, of this name and version."""
    (tmp_path / "listed_robot.py").write_text(MODULE)
    (tmp_path / "quitting_robot.py").write_text("import sys\nsys.exit('no licence')\n")
    monkeypatch.syspath_prepend(tmp_path)

    def make(name: str, value: str, package: str = "robots", number: str = "1.2") -> EntryPoint:
        info = tmp_path / f"{package}-{number}.dist-info"
        info.mkdir(exist_ok=True)
        (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {package}\nVersion: {number}\n")
        (info / "entry_points.txt").write_text(f"[{GROUP}]\n{name} = {value}\n")
        (found,) = PathDistribution(info).entry_points
        return found

    yield make
    sys.modules.pop("listed_robot", None)


def test_a_driver_is_listed_with_its_package_and_the_first_line_of_its_factory(
    package: Callable[..., EntryPoint],
) -> None:
    listed = list_drivers([package("wobbly", "listed_robot:described"), package("mute", "listed_robot:silent")])
    assert listed == [
        ListedDriver("mute", "from robots 1.2", listing.UNDESCRIBED),
        ListedDriver("wobbly", "from robots 1.2", "A robot of this test."),
    ]
    assert str(listed[1]) == "wobbly (from robots 1.2): A robot of this test."


@pytest.mark.parametrize(
    ("value", "why"),
    [
        ("no_such_robot:make", "no_such_robot:make raised ModuleNotFoundError: No module named 'no_such_robot'"),
        ("listed_robot:gone", "raised AttributeError"),
        ("quitting_robot:make", "raised SystemExit: no licence"),
        ("listed_robot:answer", "cannot be called"),
    ],
)
def test_a_driver_that_cannot_be_used_says_why_and_the_others_are_listed(
    package: Callable[..., EntryPoint], value: str, why: str
) -> None:
    broken, good = list_drivers([package("broken", value), package("good", "listed_robot:described")])
    assert why in broken.missing
    assert str(broken).startswith("broken (from robots 1.2): CANNOT BE USED: ")
    assert not good.missing


def test_two_packages_of_one_name_are_told_of_each_other(package: Callable[..., EntryPoint]) -> None:
    twice = [package("arm", "listed_robot:described", who, "3") for who in ("robots", "others")]
    listed = list_drivers(twice)
    assert {driver.origin for driver in listed} == {"from robots 3", "from others 3"}
    assert all("another package provides arm too: uninstall one" in str(driver) for driver in listed)


def test_the_simulated_driver_says_what_installs_what_it_lacks(
    package: Callable[..., EntryPoint], monkeypatch: pytest.MonkeyPatch
) -> None:
    own = package("simulated", "remote_site.drivers.factories:simulated", "farhand", "0.1.0")
    (there,) = list_drivers([own])
    assert (there.origin, there.missing) == ("ships with farhand 0.1.0", "")
    monkeypatch.setattr(listing, "find_spec", lambda name: None if name == "mujoco" else name)
    (lacking,) = list_drivers([own])
    assert "pip install 'farhand[sim]'" in str(lacking)
    (foreign,) = list_drivers([package("simulated", "listed_robot:described")])
    assert not foreign.missing
