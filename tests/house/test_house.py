"""Rules of the house that no linter knows."""

import ast
import re
import subprocess
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]

# Spelled so that this file does not match itself.
FOREIGN = {
    "a path of one machine": r"(?<![\w.$}~])/(?:work|home|root|opt|Users)/\w",
    "the host of a package index": r"p[y]pi\.|p[y]thonhosted|download\.p[y]torch",
    "a tool of one machine": r"\bi[s]sues (?:show|list|close|note)\b|\bf[a]rm-[a-z]",
}

LONGEST = 300
"""Lines; a file that nears it usually holds two ideas."""
CONTRACT = "test_contract.py"
"""One file tests all that a family promises, however much that is."""


@cache
def tracked(pattern: str = "*") -> list[Path]:
    listed = subprocess.run(
        ["git", "ls-files", "-z", pattern], cwd=ROOT, capture_output=True, text=True, check=True
    )
    return [path for name in listed.stdout.split("\0") if name and (path := ROOT / name).is_file()]


@cache
def text_of(file: Path) -> str:
    return file.read_text(encoding="utf-8", errors="replace")


@cache
def looked_at(file: Path) -> tuple[bool, frozenset[str]]:
    """Return whether a module says what it is, and what it imports; its tree is not kept."""
    tree = ast.parse(file.read_text(encoding="utf-8"))
    return ast.get_docstring(tree) is not None, frozenset(imported(tree))


def imported(tree: ast.Module) -> set[str]:
    """Return the modules that `import x` and `from x import y` name in a file."""
    names = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            names |= {f"import {alias.name}" for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            names.add(f"from {node.module}")
    return names


def test_there_are_files_to_check() -> None:
    assert len(tracked("*.py")) > 50


@pytest.mark.parametrize("what", FOREIGN)
def test_no_file_names(what: str) -> None:
    found = [
        f"{file.relative_to(ROOT)}:{number}: {line.strip()[:80]}"
        for file in tracked()
        if re.search(FOREIGN[what], text_of(file))
        for number, line in enumerate(text_of(file).splitlines(), 1)
        if re.search(FOREIGN[what], line)
    ]
    assert found == []


def test_no_file_is_too_long() -> None:
    lines = {file: len(text_of(file).splitlines()) for file in tracked("*.py")}
    long = {file: n for file, n in lines.items() if n > LONGEST and file.name != CONTRACT}
    assert {str(file.relative_to(ROOT)): n for file, n in long.items()} == {}


def test_every_module_says_what_it_is() -> None:
    silent = [
        str(file.relative_to(ROOT))
        for file in tracked("*.py")
        if not file.is_relative_to(ROOT / "tests") and not looked_at(file)[0]
    ]
    assert silent == []


def test_nothing_reads_pickles_because_they_run_what_they_hold() -> None:
    words = {
        "import pickle",
        "from pickle",
        "import dill",
        "from dill",
        "import joblib",
        "from joblib",
    }
    assert [str(file) for file in tracked("*.py") if looked_at(file)[1] & words] == []


def test_align_and_print_are_imported_as_parts_of_morph_alone() -> None:
    # By two names a module would be loaded twice, and `import print` hides the builtin.
    tops = re.compile(r"(from|import) (align|print)(\.|$)")
    wrong = [file for file in tracked("*.py") if any(map(tops.match, looked_at(file)[1]))]
    assert [str(file) for file in wrong] == []


def test_align_print_and_robots_are_linked_into_morph() -> None:
    # A checkout without symbolic links (git config core.symlinks) holds three text files instead.
    links = {"alignment": "align", "print": "print", "robots": "robots"}
    assert {name: (ROOT / "morph" / name).resolve() for name in links} == {
        name: ROOT / folder for name, folder in links.items()
    }


def test_no_folder_of_tests_is_a_package() -> None:
    assert tracked("tests/**/__init__.py") == []
