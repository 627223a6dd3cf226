"""`morph transfer --over` chooses its chain, and refuses what leaves nothing to choose."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from morph.app.cli.main import main

TOLD = ["transfer", "--from", "learned", "--trials", "2", "--repeats", "0", "--scratch", "0"]


def test_a_way_goes_over_what_it_is_given_or_past_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "carried"
    ends = ["--chain", "cartpole", "rider_rigid_passive", "--over", "rider_rigid_driven"]
    main([*TOLD, *ends, "--out", str(out)])
    chain = json.loads((out / "transfer.json").read_text(encoding="utf-8"))["chain"]
    assert chain[0] == "cartpole"
    assert chain[-1] == "rider_rigid_passive"
    assert set(chain[1:-1]) <= {"rider_rigid_driven"}
    assert f"the way that promises most: {' > '.join(chain)}" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("more", "said"),
    [
        (["--chain", "cartpole", "cart_two_links", "rider_rigid_driven"], "names 3 bodies"),
        (["--chain", "cartpole", "cart_two_links", "--samples", "20", "30"], "for each hop"),
    ],
)
def test_a_way_that_cannot_be_chosen_is_refused(
    more: list[str], said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "carried"
    assert main([*TOLD, *more, "--over", "rider_rigid_passive", "--out", str(out)]) == 2
    assert said in capsys.readouterr().err
    assert not out.exists()
