"""A module of cells that worker processes import, and the little that tests do with it."""

from __future__ import annotations

import importlib
import os
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from types import ModuleType

import pytest

TOY = '''
import os, signal, time
from dataclasses import dataclass
from pathlib import Path
from morph.errors import TaskError

FACTOR = 1

def square(x, factor=1):
    return {"x": x, "square": FACTOR * factor * x * x}

def process(x):
    return {"pid": os.getpid()}

def threads(x):
    return {"threads": os.environ["OMP_NUM_THREADS"]}

@dataclass(frozen=True)
class Pair:
    left: int
    right: tuple[int, ...] = ()

def added(pair):
    assert type(pair) is Pair and type(pair.right) is tuple
    return {"sum": pair.left + sum(pair.right), "pair": pair}

def spoiled(x):
    if x == 1:
        raise TaskError("a pole of -1 m", where="toy", fix="make it longer")
    if x == 2:
        raise KeyError("nothing of that name")
    if x == 3:
        raise SystemExit(0)
    if x == 4:
        return {"x": object()}
    return {"x": x, "error": float("nan")}

def deadly(x, marks, of=()):
    """Kill its worker where `x` is one `of` these; leaves a mark for every start."""
    with open(Path(marks) / str(x), "a") as file:
        file.write("started\\n")
    if x in of:
        os.kill(os.getpid(), signal.SIGKILL)
    return {"x": x}

def deadly_once(x, marks, of=()):
    file = Path(marks) / str(x)
    first = not file.exists()
    with file.open("a") as opened:
        opened.write("started\\n")
    if x in of and first:
        os.kill(os.getpid(), signal.SIGKILL)
    return {"x": x}

def waiting(x, gate, ready):
    """Say that it runs, then wait until a file is there."""
    Path(ready, f"{x}.{os.getpid()}").touch()
    while not Path(gate).exists():
        time.sleep(0.01)
    return {"x": x}
'''


def write_module(folder: Path, name: str, text: str) -> ModuleType:
    """Return a module written into a folder, imported anew."""
    (folder / f"{name}.py").write_text(text)
    sys.modules.pop(name, None)
    importlib.invalidate_caches()
    return importlib.import_module(name)


@pytest.fixture
def toy(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[ModuleType]:
    """The module of cells, in a folder of its own, which is the current one."""
    home = tmp_path / "home"
    home.mkdir()
    monkeypatch.chdir(home)
    monkeypatch.syspath_prepend(home)
    yield write_module(home, "toy_cells", TOY)
    sys.modules.pop("toy_cells", None)


@pytest.fixture
def marks(tmp_path: Path) -> Path:
    """A folder where cells leave a mark each time they start."""
    folder = tmp_path / "marks"
    folder.mkdir()
    return folder


@pytest.fixture
def starts(marks: Path) -> Callable[[], dict[str, int]]:
    """How often each cell has started."""
    return lambda: {
        path.name: len(path.read_text().splitlines()) for path in sorted(marks.iterdir())
    }


def alive(pid: int) -> bool:
    """Return whether a process is there and has not ended."""
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    state = Path(f"/proc/{pid}/stat")
    return not state.exists() or state.read_text().rpartition(")")[2].split()[0] != "Z"
