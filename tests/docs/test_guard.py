"""The page on the guard says what holds."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

TEXT = (Path(__file__).resolve().parents[2] / "docs" / "guard.md").read_text(encoding="utf-8")


def test_its_blocks_run_one_after_another(capsys: pytest.CaptureFixture[str]) -> None:
    known: dict[str, object] = {}
    for code in re.findall(r"```python\n(.*?)```", TEXT, re.DOTALL):
        exec(compile(code, "docs/guard.md", "exec"), known)
    believed, good, bad = capsys.readouterr().out.splitlines()
    assert "is believed of" in believed
    assert good.endswith(": safe")
    assert bad.endswith(": unsafe")
