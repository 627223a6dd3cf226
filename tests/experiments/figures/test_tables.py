"""The tables of figures are what the result files say, and no other figure stands in them."""

from __future__ import annotations

import re
import shlex
import subprocess
import sys
from importlib import import_module
from pathlib import Path

import pytest

from experiments.figures.__main__ import print_commands
from experiments.figures.catalogue import Statement, Study, load_catalogue
from experiments.figures.result_file import RESULTS, ROOT, Start, encode, load_result, save_result
from experiments.figures.result_schema import with_digest
from experiments.figures.tables import (
    check_templates,
    pages,
    replace_between,
    stale_results,
)
from experiments.figures.templates import literal_figures
from morph.errors import StudyError

NOTES = ROOT / "experiments" / "notes"
STUDIES, WORDS = load_catalogue()
CATALOGUE = """
words = ["R2"]
[[study]]
name = "sums"
command = "experiments.interval --count 3"
answers = "What is the sum?"
headline = "{sums.total}, shuffled {sums.controls.shuffled.total}"
notes = "sums"
[[study.readme]]
question = "the sum of {sums.settings.count} numbers"
figure = "{sums.total}"
baseline = "shuffled {sums.controls.shuffled.total}"
[[study]]
name = "products"
command = "experiments.interval --product"
answers = "What is the product?"
headline = "{products.total}"
notes = "sums"
minutes = 2
"""
PAGE = "before\n<!-- figures: begin table -->\nold\n<!-- figures: end table -->\nafter\n"


@pytest.fixture
def root(tmp_path: Path) -> Path:
    (tmp_path / "experiments" / "results").mkdir(parents=True)
    (tmp_path / "experiments" / "figures.toml").write_text(CATALOGUE)
    for page in ("README.md", "experiments/README.md"):
        (tmp_path / page).write_text(PAGE)
    save_result(
        tmp_path / "experiments" / "results" / "sums.json",
        start=Start.now("experiments.interval"),
        command="experiments.interval --count 3",
        settings={"count": 3},
        seeds=[],
        figures={"total": 6},
        controls={"shuffled": {"total": 5}},
    )
    return tmp_path


def made(root: Path) -> tuple[str, str]:
    folder = root / "experiments"
    texts = pages(root, catalogue=folder / "figures.toml", folder=folder / "results")
    return texts[root / "README.md"], texts[folder / "README.md"]


def change(root: Path, **changes: object) -> None:
    path = root / "experiments" / "results" / "sums.json"
    path.write_text(encode(with_digest(load_result(path) | changes)))


def test_a_row_holds_the_figures_of_its_result_and_its_command(root: Path) -> None:
    readme, studies = made(root)
    assert "| the sum of 3 numbers | 6 | shuffled 5 | `experiments.interval --count 3` |" in readme
    assert readme.startswith("before\n")
    assert readme.endswith("after\n")
    assert "old" not in readme
    assert "| 6, shuffled 5 |" in studies


def test_a_study_without_a_result_is_stated_without_a_figure(root: Path) -> None:
    readme, studies = made(root)
    assert "product" not in readme
    waiting = studies.partition("No result file yet:")[2]
    assert "`.venv/bin/python -m experiments.interval --product` | 2 |" in waiting


def test_the_table_follows_the_result_file(root: Path) -> None:
    change(root, figures={"total": 7})
    assert "| the sum of 3 numbers | 7 |" in made(root)[0]
    (root / "experiments" / "results" / "sums.json").unlink()
    assert "the sum of" not in made(root)[0]


def test_a_result_of_another_command_is_refused(root: Path) -> None:
    change(root, command="experiments.interval --count 2")
    with pytest.raises(StudyError, match="was made by 'experiments\\.interval --count 2'"):
        made(root)


def test_a_template_that_names_a_figure_the_result_lacks_is_refused(root: Path) -> None:
    change(root, figures={"sum": 6})
    with pytest.raises(StudyError, match="has no 'total'"):
        made(root)


def test_a_result_of_a_changed_tree_is_marked(root: Path) -> None:
    change(root, commit="abcdef0" + 33 * "1", dirty=True, date="2026-01-02")
    assert "| 2026-01-02, abcdef0, tree changed |" in made(root)[1]


def test_results_of_earlier_code_are_marked_in_both_tables(root: Path) -> None:
    assert not any("\N{DAGGER}" in page for page in made(root))
    change(root, code_hash="0" * 64)
    for page in made(root):
        (row,) = [
            line
            for line in page.splitlines()
            if line.startswith("|") and "interval --count" in line
        ]
        assert row.endswith(" \N{DAGGER} |")
        assert "\n\N{DAGGER} measured by earlier code; `make results` prints" in page
    folder = root / "experiments"
    assert stale_results(folder / "figures.toml", folder / "results") == ["sums"]


def test_a_row_is_marked_where_any_result_that_it_states_is_of_earlier_code(root: Path) -> None:
    folder = root / "experiments"
    catalogue = CATALOGUE.replace(
        'figure = "{sums.total}"', 'figure = "{sums.total}, {products.total}"'
    )
    (folder / "figures.toml").write_text(catalogue)
    result = load_result(folder / "results" / "sums.json")
    command = {"command": "experiments.interval --product"}
    for code, mark in ((result["code_hash"], ""), ("0" * 64, " \N{DAGGER}")):
        other = result | command | {"code_hash": code, "date": "2026-01-02"}
        (folder / "results" / "products.json").write_text(encode(with_digest(other)))
        row = next(line for line in made(root)[0].splitlines() if "| 6, 6 |" in line)
        assert row.endswith(f"| `experiments.interval --count 3`{mark} |")


@pytest.mark.parametrize(
    "text", ["6", "six numbers", "{sums.total} of 6", "{sums.total} %, none lost"]
)
def test_a_figure_written_by_hand_is_refused(text: str) -> None:
    (study,) = (
        Study(
            name="sums",
            command="experiments.interval",
            answers="What?",
            headline="{sums.total}",
            notes="sums",
            readme=(Statement(question="what", figure=text, baseline=text),),
        ),
    )
    with pytest.raises(StudyError, match="stands outside a placeholder"):
        check_templates([study], frozenset())


def test_a_figure_is_no_word(root: Path) -> None:
    with pytest.raises(StudyError, match="'6' is a figure, not a name"):
        check_templates([], frozenset({"6"}))


@pytest.mark.parametrize("page", ["no marker", PAGE + PAGE, "".join(reversed(PAGE.split("old")))])
def test_a_page_without_its_markers_is_refused(page: str) -> None:
    with pytest.raises(StudyError, match="once each"):
        replace_between(page, "table", "new", "README.md")


# What follows is about this repository's own pages.


@pytest.mark.parametrize("page", ["README.md", "experiments/README.md"])
def test_a_page_states_what_make_figures_writes(page: str) -> None:
    path = ROOT / page
    assert path.read_text(encoding="utf-8") == pages()[path], "run make figures"


def test_every_result_file_belongs_to_a_listed_study() -> None:
    assert {path.stem for path in RESULTS.glob("*.json")} <= {study.name for study in STUDIES}


@pytest.mark.parametrize("study", STUDIES, ids=lambda study: study.name)
def test_a_study_is_a_module_with_a_page_of_notes(study: Study) -> None:
    module = ROOT.joinpath(*study.module.split("."))
    assert module.with_suffix(".py").is_file() or (module / "__main__.py").is_file()
    assert (ROOT / "experiments" / "notes" / f"{study.notes}.md").is_file()
    assert "--quick" not in shlex.split(study.command)


class Started(Exception):
    """The study would begin now."""


@pytest.mark.parametrize("study", STUDIES, ids=lambda study: study.name)
def test_a_listed_command_may_save_its_result(
    study: Study, monkeypatch: pytest.MonkeyPatch
) -> None:
    def start(module: str) -> Start:
        assert module.removesuffix(".__main__") == study.module
        raise Started

    monkeypatch.setattr("experiments.figures.save_options.Start.now", start)
    path = ROOT.joinpath(*study.module.split("."))
    module = import_module(f"{study.module}.__main__" if path.is_dir() else study.module)
    with pytest.raises(Started):
        module.main([*shlex.split(study.command)[1:], "--save"])


SETTINGS = (
    *("Python 3.11", "Apache-2.0", "CC BY-SA 4.0", "SO-101", "3MF", "Three bodies", "two\ndiffer"),
    *("## Three commands", "one of thirty", "two explanations", "one piece of physics"),
    *("at 50 Hz or more", "at least two runs of about five seconds", "1. ", "2. ", "3. "),
)
"""What README may say in numbers, since nothing of it was measured: counts of what is listed,
defaults, what a recording needs, statuses, and names."""


def test_the_readme_states_no_figure_outside_its_table() -> None:
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    before, _, rest = text.partition("<!-- figures: begin table -->")
    text = before + rest.partition("<!-- figures: end table -->")[2]
    for code in (r"^```.*?^```", r"`[^`\n]*`", r"\]\([^)]*\)", "<!--.*?-->"):
        text = re.sub(code, " ", text, flags=re.DOTALL | re.MULTILINE)
    for phrase in SETTINGS:
        text = text.replace(phrase, " ")
    assert literal_figures(re.sub("[{}]", " ", text), frozenset()) == []


@pytest.mark.parametrize("page", sorted(path.name for path in NOTES.glob("*.md")))
def test_a_command_of_a_listed_study_stands_in_the_table_alone(page: str) -> None:
    listed = {study.module for study in STUDIES}
    # Parts of a study that no listed command runs keep theirs.
    others = ("moments", "throughput", "growth", "figure8")
    for line in (NOTES / page).read_text(encoding="utf-8").splitlines():
        named = re.search(r"^- Command: .*-m (experiments\.\w+)", line)
        if named and not any(f"--only {part}" in line for part in others):
            assert named[1] not in listed, line


def test_the_commands_are_those_of_missing_stale_and_damaged_results(
    root: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = root / "experiments"

    def printed() -> str:
        print_commands(folder / "figures.toml", folder / "results")
        return capsys.readouterr().out

    product = ".venv/bin/python -m experiments.interval --product --save  # missing, 2 min\n"
    total = ".venv/bin/python -m experiments.interval --count 3 --save  # {}, ? min\n"
    assert printed() == product
    change(root, code_hash="0" * 64)
    assert printed() == total.format("stale") + product
    (folder / "results" / "sums.json").write_text("{")
    assert printed() == total.format("damaged") + product


def test_every_result_file_is_as_it_was_saved() -> None:
    for path in RESULTS.glob("*.json"):
        assert load_result(path)["figures"], path.name


def test_a_reader_of_the_commands_may_go_before_the_end() -> None:
    words = [sys.executable, "-m", "experiments.figures", "--commands"]
    with subprocess.Popen(
        words, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.PIPE
    ) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        process.stdout.close()
        assert process.stderr.read() == b""
    # What a shell says of a program that SIGPIPE ended.
    assert process.returncode == 141
