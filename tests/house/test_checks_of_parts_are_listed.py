"""Every check of parts has its row in the documentation."""

from __future__ import annotations

import ast
import re
from pathlib import Path

from morph.print.check.checks import CHECKS
from morph.print.clearance import NAME

ROOT = Path(__file__).parents[2]


def made() -> set[str]:
    """Return the names that checks are given outside the list of rules."""
    files = [*(ROOT / "print").glob("*.py"), *(ROOT / "morph" / "fabrication").glob("*.py")]
    calls = (
        node
        for file in files
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8")))
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name)
    )
    return {
        str(word.value.value)
        for call in calls
        if isinstance(call.func, ast.Name) and call.func.id == "Check"
        for word in call.keywords
        if word.arg == "name" and isinstance(word.value, ast.Constant)
    }


def test_every_check_of_parts_has_its_row_and_no_other_has() -> None:
    text = (ROOT / "docs" / "print.md").read_text(encoding="utf-8")
    table = text.split("| check |")[1].split("\n\n")[0]
    rows = set(re.findall(r"^\| `([^`]+)` \|", table, re.MULTILINE))
    assert rows == {rule.name for rule in CHECKS} | made() | {NAME}
