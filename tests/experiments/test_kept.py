"""Cases that are kept as they finish."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path

from experiments.codesign import Case
from experiments.kept import finished, seeds_of


def test_seeds_are_a_count_or_a_range() -> None:
    assert list(seeds_of("3")) == [0, 1, 2]
    assert list(seeds_of("100:102")) == [100, 101]


def test_processes_give_rows_in_the_order_of_the_cases(tmp_path: Path) -> None:
    cases = [Case(seed=seed, way="chance") for seed in (3, 1, 2)]
    kept = tmp_path / "kept.jsonl"
    rows = finished(cases, asdict, kept=kept, workers=2)
    assert [row["seed"] for row in rows] == [3, 1, 2]
    assert kept.read_text().count('"case"') == 3


def test_a_line_that_a_kill_cut_short_is_done_again(tmp_path: Path) -> None:
    cases = [Case(seed=seed, way="chance") for seed in (1, 2)]
    kept = tmp_path / "kept.jsonl"
    finished(cases, asdict, kept=kept, workers=1)
    text = kept.read_text()
    kept.write_text(text[:-20])
    done: list[int] = []

    def noted(case: Case) -> dict[str, object]:
        done.append(case.seed)
        return asdict(case)

    for _ in range(2):
        assert len(finished(cases, noted, kept=kept, workers=1)) == 2
    assert done == [2]
