"""The page on chains says what holds."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

PAGE = Path(__file__).resolve().parents[2] / "docs" / "chains.md"


def test_the_chain_of_balance_on_the_page_balances() -> None:
    text = PAGE.read_text(encoding="utf-8")
    block = re.findall(r"```python\n(.*?)```", text, flags=re.DOTALL)[0]
    names: dict[str, Any] = {}
    exec(compile(block, str(PAGE), "exec"), names)
    hops = names["carried"].hops
    # Twenty transitions through little noise hold a rigid rider: 0.999 where it was tried.
    assert all(hop.scores["zero_shot"] > 0.95 for hop in hops)
    assert names["carried"].samples == 20 * len(hops)
