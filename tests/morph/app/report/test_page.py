import itertools
import json
from collections.abc import Callable
from dataclasses import replace
from html.parser import HTMLParser

import numpy as np
import pytest

from morph.app.report.curves import MOST_POINTS, MOST_TRACES, curves, thinned
from morph.app.report.page import report_page
from morph.app.report.words import headline
from morph.model.diagnosis import Diagnosis

LOADING = {"src", "href", "srcset", "data", "action", "poster", "background", "xlink:href"}
HOSTILE = (
    "<script>alert(1)</script>",
    "</script><script>alert(1)</script>",
    "<!--<script>",
    "\" onmouseover='alert(1)' x=\"",
    "{{ 7 * 7 }}",
)


class Page(HTMLParser):
    """A page's elements with their attributes, its scripts, and its words in order."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.elements: list[tuple[str, dict[str, str | None]]] = []
        self.words: list[str] = []
        self.scripts: list[str] = []
        self.within = ""
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.elements.append((tag, dict(attrs)))
        self.within = tag
        if tag == "script":
            self.scripts.append("")

    def handle_endtag(self, tag: str) -> None:
        self.within = ""

    def handle_data(self, data: str) -> None:
        if self.within == "script":
            self.scripts[-1] += data
        elif self.within != "style" and data.strip():
            self.words.append(data.strip())

    def plots(self) -> object:
        return json.loads(self.scripts[0])


def words(page: Page) -> str:
    return " ".join(page.words).replace("\N{NO-BREAK SPACE}", " ")


def test_the_finding_in_words_comes_before_every_table_and_drawing(mismatch: Diagnosis) -> None:
    text = report_page(mismatch)
    body = text[text.index("<body>") :]
    first = min(body.index("<table"), body.index('class="track"'), body.index("<figure"))
    assert body.index("Two things were left out of the simulation") < first
    for sentence in mismatch.summary():
        assert body.index(sentence) < first


def test_what_is_hardly_likely_is_not_counted(mismatch: Diagnosis) -> None:
    first, second = mismatch.findings
    weak = replace(mismatch, findings=(first, replace(second, probability=0.03)))
    assert headline(weak) == "One thing was left out of the simulation, and perhaps more"
    weaker = replace(weak, findings=tuple(replace(f, probability=0.2) for f in weak.findings))
    assert headline(weaker) == "Something was perhaps left out of the simulation"


def test_the_improvement_on_unseen_runs_is_told_before_the_findings(mismatch: Diagnosis) -> None:
    told = words(Page(report_page(mismatch)))
    line = (
        "On three runs that it never saw, the corrected simulation is off by "
        "0.052 rad at elbow.position (as given 0.476, refitted 0.301, sensor noise 0.0012); "
        "0.031 rad at shoulder.position (as given 0.264, refitted 0.17, sensor noise 0.0011)."
    )
    assert line in told
    assert "At least 96 % of the squared error is gone" in told
    assert told.index(line) < told.index("What was left out")
    # 0.476 / 0.052 = 9.15.
    assert "9.2 times" in told


def test_each_finding_names_rivals_and_the_experiment_that_tells_them_apart(
    mismatch: Diagnosis,
) -> None:
    told = words(Page(report_page(mismatch)))
    assert "0.081 N m (0.077 to 0.085)" in told.replace("  ", " ")
    assert "viscous friction at joint shoulder (2 %); Stribeck friction" in told
    assert "Record this: Two constant speeds at least five times apart" in told


def test_a_robot_that_agrees_is_told_so_without_findings_or_plots(consistent: Diagnosis) -> None:
    text = report_page(consistent)
    told = words(Page(text))
    assert "No difference shows in these recordings" in told
    assert "What was left out" not in told
    assert "corrected.xml" not in told
    # Without plots the page carries no scripts.
    assert "<script" not in text
    assert len(text) < 50_000


def test_an_unknown_verdict_says_that_nothing_was_found_and_that_time_ran_out(
    unknown: Diagnosis,
) -> None:
    told = words(Page(report_page(unknown)))
    assert "what is missing was not found" in told
    assert "Stopped short." in told
    assert "simulated over whole episodes" in told


def test_findings_that_do_not_hold_are_only_suspected(mismatch: Diagnosis) -> None:
    rmse = {**mismatch.held_out_rmse, "rejected": mismatch.held_out_rmse["corrected"]}
    refuted = replace(mismatch, verdict="unknown", held_out_rmse=rmse)
    told = words(Page(report_page(refuted)))
    assert "no correction holds on held-out runs" in told
    assert "What was suspected" in told
    assert "What remains unexplained" in told
    assert "the corrected simulation is off" not in told


@pytest.mark.parametrize("name", HOSTILE)
def test_a_hostile_name_is_shown_and_never_obeyed(
    renamed: Callable[[str], Diagnosis], name: str
) -> None:
    harmless, hostile = (Page(report_page(renamed(n))) for n in ("plain", name))
    # The same elements with the same kinds of attributes: a name made none of its own.
    shape = [(tag, set(attributes)) for tag, attributes in harmless.elements]
    assert [(tag, set(attributes)) for tag, attributes in hostile.elements] == shape
    assert len(hostile.scripts) == 3
    assert name in words(hostile)


def test_no_name_from_a_file_reaches_the_scripts(renamed: Callable[[str], Diagnosis]) -> None:
    page = Page(report_page(renamed("zzyzx")))
    assert not any("zzyzx" in script for script in page.scripts)


def test_the_page_loads_nothing(mismatch: Diagnosis) -> None:
    text = report_page(mismatch)
    page = Page(text)
    assert [e for e in page.elements if LOADING & set(e[1])] == []
    assert {"link", "img", "iframe", "object", "embed"} & {tag for tag, _ in page.elements} == set()
    style = text[text.index("<style>") : text.index("</style>")]
    assert "url(" not in style
    assert "@import" not in style


def test_the_page_forbids_browsers_to_load_or_run_anything_else(mismatch: Diagnosis) -> None:
    (policy,) = (
        attributes["content"]
        for tag, attributes in Page(report_page(mismatch)).elements
        if attributes.get("http-equiv") == "Content-Security-Policy"
    )
    assert policy is not None
    assert policy.startswith("default-src 'none';")
    assert policy.count("'sha256-") == 2


def test_the_page_stays_under_six_megabytes_with_many_long_runs(mismatch: Diagnosis) -> None:
    one = mismatch.traces[0]
    many = [replace(one, episode=f"run {n}", channel=f"{m}") for n in range(60) for m in range(8)]
    text = report_page(replace(mismatch, traces=tuple(many)))
    assert len(text.encode()) < 6e6
    # 144 traces / 8 channels = 18 episodes; 60 - 18 = 42 are not drawn.
    assert MOST_TRACES == 144
    assert "The first 18 held-out episodes are drawn; 42 more are not." in words(Page(text))


def test_a_plot_holds_the_readings_with_the_gap_between_rollouts(mismatch: Diagnosis) -> None:
    plots = Page(report_page(mismatch)).plots()
    assert plots == curves(mismatch)
    curve = curves(mismatch)["curves"][0]
    assert curve["time"].count(None) == 1
    assert len(curve["time"]) == len(curve["measured"]) == len(curve["models"][2]) <= MOST_POINTS
    assert curve["models"][2][0] == pytest.approx(0.98 * curve["measured"][0], rel=1e-4)


@pytest.mark.parametrize("samples", [1, 1500, 1501, 50_000])
def test_thinning_keeps_gaps_and_bounds_the_points(samples: int) -> None:
    time = np.linspace(0.0, 1.0, samples)
    time[samples // 2 :: 100] = np.nan
    places = thinned(time, MOST_POINTS)
    assert np.isnan(time[places]).sum() == np.isnan(time).sum()
    assert len(places) <= MOST_POINTS + 1


def test_a_simulation_that_blew_up_is_called_so_and_does_not_flatten_its_plot(
    mismatch: Diagnosis,
) -> None:
    one = mismatch.traces[0]
    wild = {**one.models, "nominal": np.append(np.geomspace(1.0, 1e9, 4999), np.inf)}
    rmse = {**mismatch.held_out_rmse, "nominal": {"elbow.position": np.inf}}
    diagnosis = replace(mismatch, traces=(replace(one, models=wild),), held_out_rmse=rmse)
    assert "as given diverged" in words(Page(report_page(diagnosis)))
    low, high = curves(diagnosis)["curves"][0]["range"]
    # The readings span less than 2 rad; the frame adds at most one span to either side.
    assert -6.0 < low < high < 6.0


def test_every_drawing_has_words_for_those_who_cannot_see_it(mismatch: Diagnosis) -> None:
    drawings = [e for e in Page(report_page(mismatch)).elements if e[1].get("role") == "img"]
    assert len(drawings) > 10
    assert all(attributes.get("aria-label") for _, attributes in drawings)


def test_headings_step_down_one_level_at_a_time(mismatch: Diagnosis) -> None:
    tags = [tag for tag, _ in Page(report_page(mismatch)).elements]
    levels = [int(tag[1]) for tag in tags if tag in {"h1", "h2", "h3", "h4"}]
    assert levels[0] == 1
    assert levels.count(1) == 1
    assert all(after - before <= 1 for before, after in itertools.pairwise(levels))


def test_a_part_keeps_the_name_that_its_file_gives_it(mismatch: Diagnosis) -> None:
    probabilities = {"unknown": 0.2, "coulomb_friction@left_hip": 0.8}
    told = words(Page(report_page(replace(mismatch, probabilities=probabilities))))
    assert "something not explained" in told
    assert "Coulomb friction at left_hip" in told
