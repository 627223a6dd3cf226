"""Files that a user names are opened by `morph.regular_file`, or somebody says why not."""

import ast
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PACKAGES = ("morph", "align", "print")

READS = re.compile(
    r"(os|io|gzip|bz2|lzma|tarfile|Image)\.open|.+\.(read_bytes|read_text|fromfile|from_file"
    r"|from_xml_path)|(np|numpy|trimesh)\.load\w*|zipfile\.ZipFile|sqlite3\.connect|h5py\.File"
    r"|(ElementTree|ET)\.(parse|iterparse)|open",
    re.DOTALL,
)
"""Calls that may open a file by its name, as they are written."""

OURS = "it is a part of the package itself"
WRITES = "it only writes, or holds a lock"
BYTES = "it is given bytes, or a file that is open"
MADE = "it was made by this process, in a folder of its own"

ALLOWED = {
    "morph/regular_file.py": "this is where files are opened",
    "morph/app/report/align/page.py": OURS,
    "morph/app/report/page.py": OURS,
    "morph/app/report/loop/page.py": OURS,
    "morph/app/report/learn/page.py": OURS,
    "morph/app/report/print/page.py": OURS,
    "morph/app/viewer/export/page.py": OURS,
    "morph/app/viewer/front_page.py": "it is a part of viser",
    "morph/app/viewer/style.py": OURS,
    "print/sheet.py": OURS,
    "morph/app/cli/list.py": OURS,
    "morph/study/submitit_local.py": WRITES,
    "morph/study/code_hash.py": "it is source code that is imported",
    "morph/app/viewer/printed/package_zip.py": WRITES,
    "morph/app/cli/main.py": "it is /dev/null",
    "morph/body/quiet.py": "it is /dev/null",
    "morph/native/compilers.py": "it is /proc/cpuinfo",
    "morph/atomic_directory.py": WRITES,
    "morph/run_folder.py": WRITES,
    "morph/policy_transfer/link/journal.py": "it is locked before it is read; so is its folder",
    "morph/body/mesh/step.py": MADE,
    "print/slicer.py": MADE,
    "print/run_with_timeout.py": MADE,
    "morph/app/cli/print.py": "it is the package that was written just now",
    "morph/app/cli/weigh.py": "it is the package that was written just now",
    "morph/npz.py": BYTES,
    "morph/body/mesh/threemf.py": BYTES,
    "morph/record/read/sqlite.py": "SQLite opens it by its name, after `size_of` has looked at it",
    "morph/record/read/hdf5_child.py": "HDF5 opens it by its name, after `size_of` has looked",
    "align/maps/files.py": "align knows nothing of morph; it looks for a plain file itself",
    "print/threemf_read.py": "print knows nothing of morph; it looks for a plain file itself",
}
"""Files that open others without it, and why that is right."""


def opened(text: str) -> list[str]:
    """Return the calls in a file that may open another for reading, with their lines."""
    found = []
    for node in ast.walk(ast.parse(text)):
        if not isinstance(node, ast.Call):
            continue
        name = ast.unparse(node.func)
        method = isinstance(node.func, ast.Attribute) and node.func.attr == "open"
        # `path.open()` or `path.open("rb")`; what a robot or a panel opens is told no mode.
        modes = [a.value for a in node.args if isinstance(a, ast.Constant)]
        plain = method and (
            not node.args or any(re.fullmatch(r"[rwax+bt]+", str(m)) for m in modes)
        )
        if READS.fullmatch(name) or plain:
            found.append(f"{node.lineno}: {name}")
    return found


def sources() -> dict[str, str]:
    """Return the texts of all packages by their paths."""
    paths = [path for package in PACKAGES for path in (ROOT / package).rglob("*.py")]
    return {str(path.relative_to(ROOT)): path.read_text(encoding="utf-8") for path in paths}


def test_all_other_files_are_opened_by_the_one_who_looks_first() -> None:
    found = {path: calls for path, text in sources().items() if (calls := opened(text))}
    assert {path: calls for path, calls in found.items() if path not in ALLOWED} == {}
    assert sorted(set(ALLOWED) - set(found)) == [], "these open nothing any more"


@pytest.mark.parametrize(
    "call",
    [
        "open(path)",
        "path.open()",
        "(folder / name).open('rb')",
        "path.read_bytes()",
        "self.path.with_suffix('.x').read_text(encoding='utf-8')",
        "np.load(path, allow_pickle=False)",
        "os.open(path, os.O_RDONLY)",
        "h5py.File(path)",
        "mujoco.MjSpec.from_file(str(path))",
    ],
)
def test_a_reader_that_opens_a_path_itself_is_found(call: str) -> None:
    assert len(opened(f"x = {call}\n")) == 1


@pytest.mark.parametrize(
    "call", ["open_regular(path)", "panel.open(section)", "read_bytes(path, 9)"]
)
def test_what_opens_no_path_is_not_found(call: str) -> None:
    assert opened(f"x = {call}\n") == []
