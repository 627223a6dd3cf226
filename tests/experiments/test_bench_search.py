"""The benchmark of searches and the study of the shelf, small."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from experiments import bench_search, shelf


def test_a_part_of_the_benchmark_gives_its_figures(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    # The search of a swing-up takes seconds, and the controls below make one.
    monkeypatch.setattr(bench_search, "INSIDE", (("lqr", "balance", "cartpole"),))
    told = ["--quick", "--only", "inside", "throughput", "--seed", "100", "--json"]
    assert bench_search.main(told) == 0
    found = json.loads(capsys.readouterr().out)
    (inside,) = found["inside"]
    assert inside["seeds"] == 1
    assert inside["runs"][0]["seed"] == 100
    # Without commands an upright pole falls.
    assert inside["median_loss"] < 0.5 * inside["doing_nothing"]["loss"]
    assert set(found["throughput"]) == {"implicitfast", "rk4"}


def test_the_rows_of_the_controls_give_their_figures(tmp_path: Path) -> None:
    file = tmp_path / "controls.json"
    words = ["--quick", "--only", "controls", "--seed", "100", "--save-as", str(file)]
    assert bench_search.main(words) == 0
    result = json.loads(file.read_text())
    rows = {row["name"]: row for row in result["rows"]}
    assert set(rows) == {"the learned policy", *result["controls"]}
    for name, row in rows.items():
        assert len(row["losses"]) == len(row["successes"]) == 100
        figure = result["figures"][f"{name.replace(' ', '_')}_loss"]
        # Six digits are kept of each.
        assert sum(row["losses"]) / 100 == pytest.approx(figure, rel=1e-5)
    # Hanging costs 61, and the best swing that is known about 14.
    assert 10.0 < rows["the learned policy"]["loss"] < 20.0
    assert rows["doing nothing"]["loss"] == pytest.approx(61.0, abs=0.5)


def test_the_shelf_is_learned_by_commands_and_kept(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    told = ["--out", str(tmp_path), "--only", "pendulum", "--engine", "inline"]
    assert shelf.main(told) == 0
    first = capfd.readouterr()
    assert "morph learn swing-up --robot pendulum" in first.err
    assert "1 of 1 bodies" in first.out
    assert shelf.main([*told, "--resume"]) == 0
    # What is there is told again and not made again.
    assert "morph learn" not in capfd.readouterr().err


def test_a_body_that_the_shelf_lacks_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    assert shelf.main(["--only", "no_such_body", "--out", "unused"]) == 2
    assert "no_such_body" in capsys.readouterr().err
