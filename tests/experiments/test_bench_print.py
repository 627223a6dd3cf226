from __future__ import annotations

import json
import time
from pathlib import Path

import pytest

from experiments import bench_print


def test_the_json_holds_the_command_its_stages_and_the_checks(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "bench.json"
    words = ["quadruped_printed", "--parts", "6", "--json", "--out", str(out)]
    assert bench_print.main(words) in (0, 1)
    rows = json.loads(capsys.readouterr().out)
    assert rows == json.loads(out.read_text())
    said = [row["what"].strip() for row in rows]
    assert said[0] == "morph print quadruped_printed, without a slicer"
    assert said[-1] == "checks of 6 parts and 8 joints"
    assert {"dividing", "looking", "turning", "estimating", "laying"} < set(said)
    # The stages are within the command, whose start they lack.
    assert sum(row["processor"] for row in rows[1:-1]) < rows[0]["processor"] + 5


def test_the_processor_is_told_apart_from_the_clock() -> None:
    slept = bench_print.timed("sleep", lambda: time.sleep(0.3))
    assert slept.wall >= 0.3
    assert slept.processor < 0.2
