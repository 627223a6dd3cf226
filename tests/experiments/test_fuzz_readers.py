from __future__ import annotations

import random
import sys
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import pytest

from experiments import fuzz_readers
from experiments.fuzz_readers import TARGETS, place_in, placed, run
from experiments.fuzz_seeds import spoil

LONGEST = 120
"""s; a second of fuzzing is told as a number of files, which a busy machine takes longer for."""

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
    ways = {spoil(content, random.Random(seed)) for seed in range(100)}
    assert len(ways) > 80
    for each in ways:
        ElementTree.fromstring(each)


@pytest.mark.parametrize("clone", ["morph", "other"])
def test_a_crash_is_of_the_package_and_not_of_the_folder_that_the_package_is_in(
    clone: str, tmp_path: Path
) -> None:
    # A file of the package, one beside it, and one of a package that is installed in the clone.
    package = tmp_path / clone / "morph"
    library = tmp_path / clone / ".venv" / "library.py"
    sources = {
        package / "reader.py": f"exec(compile(library, {str(library)!r}, 'exec'))",
        tmp_path / clone / "target.py": "raise KeyError('planted')",
        library: "raise KeyError('planted')",
    }

    def place(path: Path) -> str:
        names = {"library": sources[library]}
        with pytest.raises(KeyError) as found:
            exec(compile(sources[path], str(path), "exec"), names)
        return place_in(package, found.value)

    # What a library raises is put down to the line of the package that called it.
    assert place(package / "reader.py") == "reader_1"
    assert place(tmp_path / clone / "target.py") == "nowhere"
    assert place(library) == "nowhere"


def test_a_defect_is_found_and_its_file_kept(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # A reader that fails on every file with a nan in it, which is the first of hostile values.
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
    result = run("planted", LONGEST, tmp_path / "out", files=1000)
    assert min(result["read"], result["refused"], result["crashed"]) > 0
    assert result["found"] == ["planted-crash-KeyError-nowhere"]
    assert b"nan" in (tmp_path / "out" / "planted-crash-KeyError-nowhere").read_bytes()


@pytest.mark.parametrize("name", ["urdf", "mjcf", "xacro", "assembly", "ply"])
def test_a_short_run_finds_nothing(name: str, tmp_path: Path) -> None:
    result = run(name, LONGEST, tmp_path, files=200)
    assert result["found"] == []
    assert result["read"] > 0
    assert result["refused"] > 0
