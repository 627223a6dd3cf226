from __future__ import annotations

import mujoco
import pytest
from mujoco.batch import Batch

from morph.sim.threads import VARIABLE, batch_threads


@pytest.mark.parametrize(
    ("given", "rows", "threads"),
    [
        ("1", 100, 1),
        ("2", 100, 2),
        ("8", 100, 2),
        ("", 100, 2),
        # What is no positive number limits nothing: OpenMP itself takes lists such as 4,2.
        ("4,2", 100, 2),
        ("0", 100, 2),
        ("8", 16, 1),
        ("8", 17, 2),
    ],
)
def test_a_second_thread_is_taken_from_enough_rows_on_where_it_is_allowed(
    given: str, rows: int, threads: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(VARIABLE, given)
    found = batch_threads(rows, worth=17)
    assert found == threads
    assert Batch(mujoco.MjModel.from_xml_string("<mujoco/>"), rows, found).nthread == threads
