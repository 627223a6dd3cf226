"""The page on the gate says what holds."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from morph.body.load import load
from morph.sim.closed_loop import closed_loop
from morph.task.swing_up import swing_up

TEXT = (Path(__file__).resolve().parents[2] / "docs" / "gate.md").read_text(encoding="utf-8")


def test_its_block_judges_the_model_by_a_run_of_itself(capsys: pytest.CaptureFixture[str]) -> None:
    task, rng = swing_up(load("cartpole")), np.random.default_rng(100)
    pushes = np.repeat(10.0 * rng.choice([-1.0, 1.0], 15), 4)
    moved = closed_loop(
        task.simulator(),
        lambda q, v, time: pushes[None, [min(round(time / task.period), 59)]],
        np.zeros((1, 2)),
        np.zeros((1, 2)),
        period=task.period,
        seconds=task.horizon,
    )
    known: dict[str, object] = {
        "q": moved.position[0] + 0.01 * rng.standard_normal((61, 2)),
        "v": moved.velocity[0] + 0.01 * rng.standard_normal((61, 2)),
        "u": moved.command[0, :-1],
    }
    (code,) = re.findall(r"```python\n(.*?)```", TEXT, re.DOTALL)
    exec(compile(code, "docs/gate.md", "exec"), known)
    assert capsys.readouterr().out.startswith("good ")
