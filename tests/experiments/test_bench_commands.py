"""What commands cost stands beside what no command can go below."""

from __future__ import annotations

import pytest

from experiments.bench_commands import least, measure_floors, measured


def test_importing_mujoco_takes_more_memory_than_starting_python() -> None:
    rows, floors = measure_floors(1)
    assert [row["command"] for row in rows] == list(floors) == ["python started", "mujoco imported"]
    # MuJoCo's library alone has some 10 MB.
    assert floors["mujoco imported"]["memory_mb"] > floors["python started"]["memory_mb"] + 5.0


def test_the_words_of_a_command_reach_its_program() -> None:
    measured("import sys; sys.exit(sys.argv[1:] != ['inspect', 'poppy'])", "inspect", "poppy")


def test_a_program_that_fails_is_no_measurement() -> None:
    with pytest.raises(RuntimeError, match="no such robot"):
        measured("raise SystemExit('no such robot')")


def test_the_least_is_taken_of_each_quantity_by_itself() -> None:
    runs = [
        {"seconds": 2.0, "processor_s": 1.0, "memory_mb": 7.0},
        {"seconds": 1.0, "processor_s": 3.0, "memory_mb": 9.0},
    ]
    assert least(runs) == {"seconds": 1.0, "processor_s": 1.0, "memory_mb": 7.0}
