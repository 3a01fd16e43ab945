"""The page of all results: every table and figure that the sources have, from the experiments' reports alone."""

import json
import re
from typing import Any

import pytest

from common.errors import ConfigError
from lab.experiments.placing.causes import CAUSES
from lab.experiments.placing.over_network import NETWORKS
from lab.experiments.placing.series import FREE, ROLL_FIXED
from lab.experiments.report import ExperimentReport
from lab.experiments.results.printed import of_report, of_thesis
from lab.experiments.results.results_page import as_html, as_markdown, in_report, in_thesis
from lab.experiments.run import run_every

NAMES = ("calibration", "causes", "hazel", "icr", "markers", "network", "placing")
FIGURE = {"median": 2.0, "q1": 1.0, "q3": 3.0}


def reports(value=2.5):
    """A report of every experiment in which each printed figure is the same."""
    made: dict[str, dict[str, Any]] = {name: {} for name in NAMES}
    for printed in (*of_thesis(), *of_report()):
        inside = made[printed.experiment]
        for name in printed.path[:-1]:
            inside = inside.setdefault(name, {})
        inside[printed.path[-1]] = value
    over = {"placed": 9, "trials": 10, "time_s": FIGURE, "x_mm": FIGURE, "y_mm": FIGURE, "angle_deg": FIGURE}
    counts = dict.fromkeys(("drops", "collisions", "grasps_missed", "holds"), 3)
    series = {**over, **counts, "clutches": FIGURE, "contact_force_n": FIGURE}
    for rolls in (ROLL_FIXED, FREE):
        for name, of in made["placing"][rolls].items():
            medians = {error: {**FIGURE, **figure} for error, figure in of.items()}
            made["placing"][rolls][name] = {**series, **medians}
    made["network"] = {name: {**over, "picture_age_ms": 61.0} for name in NETWORKS}
    made["causes"] = {rolls: dict.fromkeys(CAUSES, over) for rolls in (FREE, ROLL_FIXED)}
    return made


def report_of(figures):
    return ExperimentReport("title", "text", "summary", figures, {}, {}, {})


def test_every_table_and_figure_of_the_thesis_is_listed():
    tables = {printed.where for printed in of_thesis()}
    assert {f"table 6.{k}" for k in range(1, 14)} <= tables
    assert {f"figure 6.{k}" for k in range(1, 17)} <= {drawn.where for drawn in in_thesis()}


def test_every_figure_of_the_reports_results_is_listed():
    assert [drawn.where for drawn in in_report()] == [f"figure {k}" for k in range(9, 23)]


def test_a_row_has_both_figures_and_the_ratio():
    page = as_markdown(reports(2.5), "1.2.3", quick=False)
    assert "| table 6.12 | a block placed, roll fixed: x | 11.6 mm | 2.5 mm | 0.22 |" in page
    assert "| 2 Mbit/s | 9 of 10 | 2 (1–3) | 2.0 | 2.0 | 2.0 | 61 |" in page
    assert "| 3 % lost |" in page
    assert "here of version 1.2.3." in page
    assert "| 120 ms each way |" in page


def test_every_series_of_placing_has_a_row_with_quartiles():
    made = reports()
    made["placing"][FREE]["assist"] = {**made["placing"][FREE]["silhouette"], "x_mm": FIGURE, "holds": 0}
    row = next(
        line for line in as_markdown(made, "1.2.3", quick=False).splitlines() if line.startswith("| all | assist |")
    )
    assert row.startswith("| all | assist | 9 of 10 | 2 (1–3) | 2.0 (1.0–3.0) |")
    assert row.endswith("| 3 | 3 | 3 | 0 | 2 (1–3) | 2 (1–3) |")


def test_why_a_series_failed_is_told_with_the_figures_and_a_row_for_every_cause():
    made = reports()
    made["causes"][FREE] = made["causes"][FREE] | {
        "exact_hand": {**made["causes"][FREE]["as_it_is"], "x_mm": {"median": 7.7}}
    }
    page = as_markdown(made, "1.2.3", quick=False)
    assert "the block is left 7.7 mm, 2.0 mm and 2.0 deg off with all rotations" in page
    assert "| exact hand | 2.0 | 2.0 | 2.0 | 9 of 10 | 2 | 7.7 | 2.0 | 2.0 | 9 of 10 | 2 |" in page
    assert len([line for line in page.splitlines() if line.count("|") == 12]) == len(CAUSES) + 2


def test_what_a_quick_run_leaves_out_is_a_dash_and_the_page_says_so():
    short = reports()
    del short["markers"]["runs"]["Farhand"]["table 6.9, XZ, wrist"]
    page = as_markdown(short, "1.2.3", quick=True)
    row = next(line for line in page.splitlines() if line.startswith("| table 6.9 |"))
    assert row.endswith("| – | – |")
    assert "quick run" in page
    assert "quick run" not in as_markdown(short, "1.2.3", quick=False)


def test_both_pages_have_the_same_numbers():
    def numbers(text):
        return re.findall(r"\d+\.\d+ mm", text)

    markdown, html = as_markdown(reports(), "1.2.3", quick=False), as_html(reports(), "1.2.3", quick=False)
    assert numbers(markdown) == numbers(html)
    assert len(numbers(markdown)) > 60


def run_counting(ran):
    made = reports()

    def run(name):
        ran.append(name)
        return report_of(made[name])

    return run


def test_what_is_done_is_not_run_again_unless_it_was_quicker_or_of_another_version(tmp_path):
    ran: list[str] = []
    for quick, version in ((True, "1"), (True, "1"), (False, "1"), (False, "2")):
        run_every(NAMES, run_counting(ran), tmp_path, quick, version)
    assert ran == [*NAMES] * 3
    assert "table 6.13" in (tmp_path / "results.md").read_text()
    assert (tmp_path / "results.html").exists()


def test_one_that_was_interrupted_leaves_what_was_done(tmp_path):
    ran: list[str] = []
    whole = run_counting(ran)

    def interrupted(name):
        if name == "markers":
            raise KeyboardInterrupt
        return whole(name)

    with pytest.raises(KeyboardInterrupt):
        run_every(NAMES, interrupted, tmp_path, False, "1")
    page = (tmp_path / "results.md").read_text()
    assert "2.5 mm" in page
    assert "The experiment `network` has not been run yet." in page
    run_every(NAMES, whole, tmp_path, False, "1")
    assert sorted(ran) == sorted(NAMES)
    assert "not been run" not in (tmp_path / "results.md").read_text()


def test_a_report_that_cannot_be_read_is_named_with_the_cure(tmp_path):
    run_every(NAMES, run_counting([]), tmp_path, False, "1")
    (tmp_path / "icr" / "report.json").write_text("{")
    with pytest.raises(ConfigError, match=r"icr.*remove"):
        run_every(NAMES, run_counting([]), tmp_path, False, "1")


def test_a_mark_of_something_else_counts_as_not_done(tmp_path):
    ran: list[str] = []
    (tmp_path / "icr").mkdir()
    (tmp_path / "icr" / "done.json").write_text(json.dumps({"version": "1"}))
    run_every(NAMES, run_counting(ran), tmp_path, False, "1")
    assert "icr" in ran
