"""The benchmark of searches and the study of the shelf, small."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from experiments import bench_search, shelf


def test_a_part_of_the_benchmark_gives_its_figures(capsys: pytest.CaptureFixture[str]) -> None:
    told = ["--quick", "--only", "inside", "throughput", "--seed", "100", "--json"]
    assert bench_search.main(told) == 0
    found = json.loads(capsys.readouterr().out)
    (inside,) = found["inside"]
    assert inside["seeds"] == 1
    assert inside["runs"][0]["seed"] == 100
    # Hanging costs 61, and the best swing that is known about 14.
    assert 10.0 < inside["median_loss"] < 61.0
    assert set(found["throughput"]) == {"implicitfast", "rk4"}


def test_the_shelf_is_learned_by_commands_and_kept(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    told = ["--out", str(tmp_path), "--only", "pendulum"]
    assert shelf.main(told) == 0
    first = capsys.readouterr()
    assert "morph learn swing-up --robot pendulum" in first.err
    assert "1 of 1 bodies" in first.out
    assert shelf.main(told) == 0
    # What is there is told again and not made again.
    assert "morph learn" not in capsys.readouterr().err


def test_a_body_that_the_shelf_lacks_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    assert shelf.main(["--only", "no_such_body", "--out", "unused"]) == 2
    assert "no_such_body" in capsys.readouterr().err
