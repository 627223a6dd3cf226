"""The page on adjusting says what holds."""

from __future__ import annotations

import importlib
import re
from pathlib import Path

import pytest

TEXT = (Path(__file__).resolve().parents[2] / "docs" / "adjust.md").read_text(encoding="utf-8")


def test_its_blocks_run_one_after_another(capsys: pytest.CaptureFixture[str]) -> None:
    known: dict[str, object] = {}
    for code in re.findall(r"```python\n(.*?)```", TEXT, re.DOTALL):
        exec(compile(code, "docs/adjust.md", "exec"), known)
    shares, beyond = capsys.readouterr().out.splitlines()
    for look in ("euclidean", "relative", "permitted"):
        assert look in shares
        assert look in TEXT
    assert 0.8 < float(beyond) < 1.5


def test_what_it_names_is_there() -> None:
    named = re.findall(r"`(morph\.policy_transfer\.[\w.]+)`", TEXT)
    assert len(named) == 4
    for each in named:
        module, _, name = each.rpartition(".")
        assert hasattr(importlib.import_module(module), name)
