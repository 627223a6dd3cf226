"""How tables, charts and notes look, on the page and in what is exported."""

from __future__ import annotations

from functools import cache
from pathlib import Path


@cache
def style() -> str:
    """Return the style sheet as an element."""
    text = Path(__file__).with_name("panel.css").read_text(encoding="utf-8")
    return f"<style>{text}</style>"
