from __future__ import annotations

import json
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from morph.errors import OutputError
from morph.study import store
from morph.study.cell import cells_of
from morph.study.engine import EngineOptions
from morph.study.run import run


def test_fresh_deletes_results_and_nothing_else(toy: ModuleType, tmp_path: Path) -> None:
    run(cells_of(toy.square, [{"x": 1}, {"x": 2}]), folder=tmp_path / "out")
    mine = tmp_path / "out" / "cells" / "mine.json"
    mine.write_text("{}")
    store.clear(tmp_path / "out")
    assert list(mine.parent.iterdir()) == [mine]
    (tmp_path / "linked").mkdir()
    (tmp_path / "linked" / "cells").symlink_to(mine.parent)
    with pytest.raises(OutputError, match="nothing is deleted behind one"):
        store.clear(tmp_path / "linked")
    assert mine.exists()


@pytest.mark.parametrize(
    "damage",
    [
        {"row": {"x": {"!float": "one"}}},
        {"row": {"x": {"!float": [1]}}},
        {"status": "excellent"},
        {"status": ["done"]},
        {"status": "failed"},
        {"error": {"what": "it is done all the same"}},
        {"status": "refused", "error": "text"},
        {"status": "refused", "error": {"where": "nowhere"}},
        {"seconds": "long"},
        {"seconds": -1.0},
        {"seconds": float("nan")},
        {"stale": "no"},
        {"code": 3},
        {"host": None},
        {"case": {"x": 2}},
        {"case": 1},
        {"schema": "morph.cell/0"},
    ],
)
def test_a_damaged_result_is_made_again(
    toy: ModuleType, tmp_path: Path, damage: dict[str, Any]
) -> None:
    out = tmp_path / "out"
    cells, options = cells_of(toy.square, [{"x": 3}]), EngineOptions(engine="inline")
    run(cells, folder=out, options=options)
    (path,) = (out / "cells").iterdir()
    whole = json.loads(path.read_text())
    assert store.read(out, cells[0].identity) == whole
    path.write_text(json.dumps(whole | damage))
    assert store.read(out, cells[0].identity) is None
    (result,) = run(cells, folder=out, options=options, resume=True)
    assert (result.status, result.row) == ("done", {"x": 3, "square": 9})
