from __future__ import annotations

import random
import sys
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import pytest

from experiments import fuzz_readers
from experiments.fuzz_readers import TARGETS, placed, run, spoiled

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="atheris is there for Linux only")


@pytest.mark.parametrize("name", TARGETS)
def test_the_file_that_fuzzing_starts_from_is_read(name: str, tmp_path: Path) -> None:
    # A seed that is refused at once would leave most of a reader unseen.
    target = TARGETS[name]
    path = placed(target, tmp_path)
    if name == "xacro":
        # Expansion here would change the xacro package for all tests that follow.
        from morph.body.xacro import expand

        assert expand(path, path.parent).count(b"<link") == 2
    else:
        assert target.reader()(path) is not None


@pytest.mark.parametrize("name", [name for name, target in TARGETS.items() if target.tree])
def test_a_tree_is_spoiled_in_many_ways_and_stays_a_tree(name: str) -> None:
    content = TARGETS[name].seed()
    ways = {spoiled(content, random.Random(seed)) for seed in range(100)}
    assert len(ways) > 80
    for each in ways:
        ElementTree.fromstring(each)


def test_a_defect_is_found_and_its_file_kept(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # A reader that fails on every file with a B in it: libFuzzer needs seconds at most.
    plant = tmp_path / "planted.py"
    plant.write_text(
        "from experiments import fuzz_readers\n"
        "from morph.errors import RecordingError\n"
        "def read(path):\n"
        "    content = path.read_bytes()\n"
        "    if b'nan' in content:\n"
        "        raise KeyError('planted')\n"
        "    if not content.startswith(b'<'):\n"
        "        raise RecordingError('no', where='here', fix='none')\n"
        "    return content\n"
        "target = fuzz_readers.Target(\n"
        "    ending='.xml', seed=lambda: b'<a b=\"1\"/>', reader=lambda: read, tree=True)\n"
        "fuzz_readers.TARGETS['planted'] = target\n"
        "raise SystemExit(fuzz_readers.main())\n"
    )
    monkeypatch.setattr(fuzz_readers, "MODULE", (str(plant),))
    result = run("planted", 4, tmp_path / "out")
    assert min(result["read"], result["refused"], result["crashed"]) > 0
    assert result["found"] == ["planted-crash-KeyError-nowhere"]
    assert b"nan" in (tmp_path / "out" / "planted-crash-KeyError-nowhere").read_bytes()


@pytest.mark.parametrize("name", ["urdf", "mjcf", "xacro", "assembly", "ply"])
def test_a_short_run_finds_nothing(name: str, tmp_path: Path) -> None:
    result = run(name, 6, tmp_path)
    assert result["found"] == []
    assert result["read"] > 0
    assert result["refused"] > 0
