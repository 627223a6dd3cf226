from __future__ import annotations

import json
import subprocess
import sys
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


def test_the_processor_is_told_apart_from_the_clock(monkeypatch: pytest.MonkeyPatch) -> None:
    clock, used = iter([10.0, 13.0]), iter([2.0, 2.5])
    monkeypatch.setattr(bench_print.time, "perf_counter", lambda: next(clock))
    monkeypatch.setattr(bench_print, "_used", lambda: next(used))
    taken = bench_print.timed("sleep", lambda: None)
    assert (taken.wall, taken.processor) == (3.0, 0.5)


def test_a_child_s_computing_counts_and_its_sleep_does_not() -> None:
    before = bench_print._used()
    work = "import time\nwhile time.process_time() < 0.1: pass\ntime.sleep(0.01)"
    subprocess.run([sys.executable, "-S", "-c", work], check=True)
    # The kernel may count in ticks of 10 ms.
    assert bench_print._used() - before > 0.08
