"""Small files that ask for much are refused for little, and what is no file is not waited for."""

from __future__ import annotations

import json
import os
import socket
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from experiments.bomb_files import BOMBS
from experiments.bomb_pieces import Bomb
from experiments.bomb_readers import READERS
from experiments.bombs import GOAL_MB, GOAL_S, headline

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def costs() -> dict[str, Any]:
    """What each bomb cost, measured within limits that end a reader which takes too much."""
    ran = subprocess.run(
        [sys.executable, "-m", "experiments.bombs", "--json"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    assert ran.returncode in (0, 1), ran.stderr
    found = [json.loads(line) for line in ran.stdout.splitlines()]
    return {each["name"]: each for each in found}


@pytest.mark.parametrize("bomb", BOMBS, ids=lambda bomb: bomb.name)
def test_a_bomb_costs_little(costs: dict[str, Any], bomb: Bomb) -> None:
    cost = costs[bomb.name]
    assert cost["memory_mb"] < GOAL_MB
    # Seconds of computing, not of waiting: what else this machine does is not counted.
    assert cost["cpu_s"] < GOAL_S
    assert bool(cost["refused"]) is not bomb.read


def test_the_worst_of_each_reader_stands_beside_a_good_file_s() -> None:
    row = {"name": "a.csv", "reader": "recording", "refused": "too large", "holds": True}
    row |= {"bytes": 9, "memory_mb": 20.0, "cpu_s": 0.1, "good_memory_mb": 3.0, "good_cpu_s": 0.2}
    rows = [row, row | {"memory_mb": 5.0, "cpu_s": 1.5}]
    rows.append(row | {"reader": "mesh", "memory_mb": 400.0, "good_cpu_s": 0.3, "holds": False})
    saved = headline(rows)
    figures = saved["figures"]
    assert (figures["recording_memory_mb"], figures["recording_cpu_s"]) == (20.0, 1.5)
    assert (figures["worst_memory_mb"], figures["over_or_not_refused"]) == (400.0, 1)
    assert saved["controls"]["a good file, recording"] == {"memory_mb": 3.0, "cpu_s": 0.2}
    assert saved["controls"]["a good file, worst"]["cpu_s"] == 0.3


NAMES = {
    "recording": ("a.csv", "a.csv.gz", "a.npz", "a.parquet", "a.h5", "a.mcap", "a.db3"),
    "binding": ("a.toml",),
    "card": ("card.toml",),
    "effects": ("a.toml",),
    "view": ("a.json",),
    "package": ("package.json",),
    "robot": ("a.urdf", "a.xml", "a.xacro"),
    "mesh": ("a.stl", "a.obj", "a.ply", "a.3mf", "a.dae", "a.step"),
    "search": ("state.npz",),
    "pairs": ("a.npz",),
    "map": ("a.npz",),
    "weights": ("weights.safetensors", "policy.json"),
}
"""Names of files for each reader."""


def put(kind: str, path: Path) -> None:
    """Put something there that is no plain file."""
    if kind == "pipe":
        os.mkfifo(path)
    elif kind == "folder":
        path.mkdir()
    elif kind == "socket":
        # The path of a socket may have 108 characters; from its folder, it has few.
        before = Path.cwd()
        os.chdir(path.parent)
        with socket.socket(socket.AF_UNIX) as made:
            made.bind(path.name)
        os.chdir(before)
    else:
        path.symlink_to("/dev/zero" if kind == "device" else path.with_name("nowhere"))


TRY = """
import json, resource, signal, sys
from pathlib import Path
from morph.alignment.errors import AlignError
from experiments.bomb_readers import READERS
from experiments.bombs import limit_memory
from morph.errors import MorphError
# A reader that waits, or reads without end, ends here and not the machine's patience.
limit_memory()
resource.setrlimit(resource.RLIMIT_CPU, (60, 60))
signal.alarm(300)
for reader, path in json.loads(sys.argv[1]):
    try:
        READERS[reader](Path(path))
        told = None
    except (MorphError, AlignError) as error:
        told = [error.what, error.where, error.fix]
    print(json.dumps([reader, path, told]), flush=True)
"""


KINDS = ("pipe", "folder", "socket", "device", "nothing")


@pytest.fixture(scope="module")
def refusals(tmp_path_factory: pytest.TempPathFactory) -> dict[str, list[Any]]:
    """What each reader answers to each kind of what is no plain file, asked in one process."""
    assert set(NAMES) == set(READERS)
    folder = tmp_path_factory.mktemp("no_files")
    asked: dict[str, list[tuple[str, str]]] = {kind: [] for kind in KINDS}
    for kind in KINDS:
        for reader, names in NAMES.items():
            (folder / kind / reader).mkdir(parents=True)
            for name in names:
                put(kind, folder / kind / reader / name)
                asked[kind].append((reader, str(folder / kind / reader / name)))
    every = [each for listed in asked.values() for each in listed]
    ran = subprocess.run(
        [sys.executable, "-c", TRY, json.dumps(every)],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    answers = [json.loads(line) for line in ran.stdout.splitlines()]
    # A reader that ends the process or waits leaves no answer: neither its own nor later ones.
    assert [tuple(answer[:2]) for answer in answers] == every, ran.stderr
    return {
        kind: [answer for answer in answers if Path(answer[1]).parts[-3] == kind] for kind in KINDS
    }


@pytest.mark.parametrize("kind", KINDS)
def test_what_is_no_plain_file_is_refused_in_three_parts_and_not_waited_for(
    refusals: dict[str, list[Any]], kind: str
) -> None:
    assert len(refusals[kind]) == sum(len(names) for names in NAMES.values())
    # A folder may hold a search's state or not; here none of its name is a file.
    for reader, path, told in refusals[kind]:
        assert told is not None or reader == "search", (reader, path)
        if told is not None:
            what, where, fix = told
            assert what
            assert fix
            assert path in where or str(Path(path).parent) in where
