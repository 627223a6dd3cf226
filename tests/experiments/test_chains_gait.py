"""The study of chains of gaits: it runs small, resumes, and counts as it says."""

import json
from pathlib import Path

import numpy as np
import pytest

from experiments.chains_gait import main
from experiments.gaits_chained.summary import summary


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    found = tmp_path_factory.mktemp("gaits")
    said = ["--quick", "--seeds", "100:101", "--chains", "aqua", "--engine", "inline"]
    assert main([*said, "--out", str(found / "cells"), "--json", str(found / "figures")]) == 0
    return found


def test_a_small_study_gives_every_figure(folder: Path) -> None:
    (figures,) = json.loads((folder / "figures").read_text())
    assert figures["seeds"] == 1
    assert figures["failed"] == []
    # Three hops of eight trials of 4 s at 50 Hz, and 20 transitions for each of 5, 9, 6 servos.
    assert figures["samples"]["iqm"] == 3 * 8 * 200 + 20 * (5 + 9 + 6)


def test_without_the_real_snake_its_chain_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("MORPH_ROBOTS", str(tmp_path))
    assert main(["--quick", "--seeds", "100:101"]) == 2
    said = capsys.readouterr().err
    assert "files of urma_sea_snake are not there" in said
    assert "--chains aqua aracna" in said


def test_direct_learning_that_never_arrives_counts_all_that_it_had() -> None:
    names = ("quadruped_printed", "quadruped_wide", "quadruped_loaded", "quadruped_four_bar")
    best = [{"case": f"best {name}", "best": {"free": 1.0}} for name in names]
    hops = [{"speed": 0.99, "samples": 100, "speeds": [0.5, 0.99]} for _ in names]
    case = {
        "case": "aracna 0",
        "chain": "aracna",
        "seed": 0,
        "hops": hops,
        "controls": {"no_source": [0.1, 0.2]},
        "direct": {"slow": [0.1] * 20, "quick": [0.1, 0.2, 0.96, 0.3]},
        "trial": 200,
    }
    figures = summary([*best, case], "aracna")
    # The quick one reaches 0.95 at its third trial; the slow one never does in twenty.
    assert figures["direct_tuned"] == "quick"
    assert figures["direct_samples_at_least"]["iqm"] == 3 * 200
    assert figures["ratio_at_most"]["iqm"] == pytest.approx(300 / 600)
    del case["direct"]["quick"]  # type: ignore[attr-defined]
    figures = summary([*best, case], "aracna")
    assert figures["direct_censored"] == 1.0
    assert figures["direct_samples_at_least"]["iqm"] == 20 * 200
    assert np.isclose(figures["after"]["1"]["chain"]["iqm"], 0.5)
