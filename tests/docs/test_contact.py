from __future__ import annotations

import re
from pathlib import Path

from morph.physics.contact.presets import SURFACES

PAGE = Path(__file__).resolve().parents[2] / "docs" / "contact.md"


def test_the_page_has_every_named_floor_with_its_numbers() -> None:
    rows = re.findall(r"^\| `(\w+)` \| ([\d.]+) \| ([\d.]+) \| (.+?) \|$", PAGE.read_text(), re.M)
    told = [(name, float(mu), float(e), rest) for name, mu, e, rest in rows]
    stiff = "as stiff as the step allows"
    assert told == [
        (s.name, s.mu, s.e, f"{s.stiffness:g}" if s.stiffness else stiff) for s in SURFACES
    ]
