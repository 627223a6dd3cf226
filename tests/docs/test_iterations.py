"""The page on iterations of one body says what holds."""

from __future__ import annotations

import re
from pathlib import Path

TEXT = (Path(__file__).resolve().parents[2] / "docs" / "iterations.md").read_text(encoding="utf-8")


def test_its_blocks_run_one_after_another() -> None:
    known: dict[str, object] = {}
    for code in re.findall(r"```python\n(.*?)```", TEXT, re.DOTALL):
        exec(compile(code, "docs/iterations.md", "exec"), known)
