"""The list of planted bugs is true, and the runner tells a bug that dies from one that lives."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from experiments.mutants.__main__ import main
from experiments.mutants.mutant import Area, MutantError, load_areas

ROOT = Path(__file__).parents[3]
AREAS = load_areas(ROOT / "experiments" / "mutants")

WORTH = """
def double(x):
    return 2 * x


def half(x):
    return x / 2


def loops(x):
    while x > 0:
        x = x - 1
    return x
"""
TESTS = """
from worth import double, loops


def test_a_double_is_twice_as_much():
    assert double(3) == 6


def test_a_loop_ends():
    assert loops(3) == 0
"""
LIST = """
tests = ["test_worth.py"]

[[mutant]]
file = "worth.py"
text = "return 2 * x"
replacement = "return 3 * x"
breaks = "a double is three times as much"

[[mutant]]
file = "worth.py"
text = "return x / 2"
replacement = "return x / 3"
breaks = "a half is a third"

[[mutant]]
file = "worth.py"
text = "return 2 * x"
replacement = "return 2 * * x"
breaks = "what cannot be read"
"""


def test_there_are_sixty_mutants_or_more_in_every_area_that_matters() -> None:
    names = {"body", "inference", "gate", "guard", "maps", "live", "masses", "reports"}
    assert names == {area.name for area in AREAS}
    assert sum(len(area.mutants) for area in AREAS) >= 60


@pytest.mark.parametrize("area", AREAS, ids=lambda area: area.name)
def test_every_mutant_still_applies_and_its_tests_exist(area: Area) -> None:
    planted = set()
    for mutant in area.mutants:
        changed = mutant.apply((ROOT / mutant.file).read_text(encoding="utf-8"))
        compile(changed, mutant.file, "exec")
        planted.add((mutant.file, changed))
        missing = [test for test in (*mutant.first, *mutant.rest) if not (ROOT / test).exists()]
        assert missing == [], mutant.breaks
    assert len(planted) == len(area.mutants)


@pytest.fixture
def toy(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    # Loading the plugins takes each pytest longer than the toy's tests.
    monkeypatch.setenv("PYTEST_DISABLE_PLUGIN_AUTOLOAD", "1")
    root = tmp_path / "toy"
    (root / "lists").mkdir(parents=True)
    (root / "worth.py").write_text(WORTH)
    (root / "test_worth.py").write_text(TESTS)
    (root / "lists" / "sums.toml").write_text(LIST)
    return root


def command(toy: Path, *more: str) -> list[str]:
    out = toy.parent / "cells"
    words = ["--root", str(toy), "--mutants", str(toy / "lists"), "--out", str(out), "--fresh"]
    return [*words, "--engine", "inline", *more]


def test_a_bug_that_a_test_sees_is_killed_and_one_that_none_sees_survives(
    toy: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "mutants.json"
    assert main(command(toy, "--save-as", str(out))) == 1
    result = json.loads(out.read_text())
    rows = {row["breaks"]: row for row in result["rows"]}
    assert [row["outcome"] for row in rows.values()] == ["killed", "survived", "killed"]
    by = rows["a double is three times as much"]["by"]
    assert by == "test_worth.py::test_a_double_is_twice_as_much"
    said = capsys.readouterr().out
    assert "2 of 3 mutants killed" in said
    assert "sums, worth.py: a half is a third" in said
    figures = result["figures"]
    assert (figures["sums_killed"], figures["sums_mutants"], figures["survived"]) == (2, 3, 1)
    assert result["controls"]["no mutant"]["sums"]["killed"] == 0
    # The repository itself is as it was.
    assert (toy / "worth.py").read_text() == WORTH


def test_a_bug_that_makes_tests_hang_is_listed_as_such(
    toy: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (toy / "lists" / "sums.toml").write_text(
        'tests = ["test_worth.py"]\n[[mutant]]\nfile = "worth.py"\ntext = "x = x - 1"\n'
        'replacement = "__import__(\'threading\').Event().wait()"\nbreaks = "a loop never ends"\n'
    )
    # A test that is slow on a busy machine would be stopped too, and listed as the same.
    assert main(command(toy, "--timeout", "0.01", "--fresh")) != 0
    assert "would kill them all" in capsys.readouterr().err
    assert main(command(toy, "--timeout", "5", "--fresh")) == 0
    said = capsys.readouterr().out
    assert "killed by the timeout alone:\n  sums, worth.py: a loop never ends" in said
    assert "1 of 1 mutants killed" in said


def test_tests_that_fail_without_a_bug_kill_nothing(
    toy: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (toy / "test_worth.py").write_text(TESTS + "\n\ndef test_never():\n    assert False\n")
    assert main(command(toy)) == 2
    assert "its tests fail without a mutant" in capsys.readouterr().err


@pytest.mark.parametrize("text", ["return 4 * x", "x"])
def test_a_mutant_that_does_not_apply_any_more_is_an_error(
    toy: Path, capsys: pytest.CaptureFixture[str], text: str
) -> None:
    path = toy / "lists" / "sums.toml"
    path.write_text(path.read_text().replace('text = "return x / 2"', f'text = "{text}"'))
    assert main(command(toy)) == 2
    said = capsys.readouterr().err
    assert "`a half is a third` occurs" in said
    assert "a text that occurs once" in said


def test_an_unknown_area_is_refused_and_the_known_ones_named(
    toy: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(command(toy, "--area", "products")) == 2
    assert "choose one of sums" in capsys.readouterr().err


def test_a_list_names_every_mutant_and_runs_nothing(
    toy: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (toy / "test_worth.py").unlink()
    assert main(command(toy, "--list")) == 0
    assert "sums: 3 mutants" in capsys.readouterr().out


def test_a_mutant_without_its_replacement_is_refused(toy: Path) -> None:
    path = toy / "lists" / "sums.toml"
    path.write_text('tests = ["t.py"]\n[[mutant]]\nfile = "worth.py"\ntext = "x"\nbreaks = "y"\n')
    with pytest.raises(MutantError, match="a mutant has breaks, file, text"):
        load_areas(path.parent)


def test_a_root_without_the_files_is_refused_in_three_parts_before_anything_is_copied(
    toy: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(command(toy, "--root", str(tmp_path / "nowhere"))) == 2
    said = capsys.readouterr().err
    assert f"{tmp_path / 'nowhere' / 'worth.py'}: cannot be read: No such file or directory" in said
    assert "fix: let --root name a repository" in said


def test_a_file_that_cannot_be_written_is_refused_before_anything_is_run(
    toy: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(SystemExit, match="2"):
        main(command(toy, "--save-as", str(tmp_path / "file" / "result.json")))
    assert "cannot write" in capsys.readouterr().err
    assert not (tmp_path / "cells").exists()


def test_rows_of_an_earlier_tree_are_refused_and_run_anew_where_asked(
    toy: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (toy / "lists" / "sums.toml").write_text(
        'tests = ["test_worth.py"]\n[[mutant]]\nfile = "worth.py"\ntext = "return x / 2"\n'
        'replacement = "return x / 3"\nbreaks = "a half is a third"\n'
    )
    assert main(command(toy)) == 1
    # A test that sees the bug.
    (toy / "test_worth.py").write_text(
        TESTS + "\n\ndef test_half():\n    from worth import half\n    assert half(6) == 3\n"
    )
    again = [word for word in command(toy) if word != "--fresh"]
    with pytest.raises(SystemExit, match="2"):
        main([*again, "--resume"])
    assert "made by other code" in capsys.readouterr().err
    assert main([*again, "--resume", "--stale", "rerun"]) == 0
