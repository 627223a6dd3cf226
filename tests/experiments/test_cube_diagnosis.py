"""Tosses of ContactNets' cube, a few of which tell friction roughly."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from experiments.cube import PUBLISHED
from experiments.cube_diagnosis import headline, main, studied
from experiments.cube_tosses import FOLDER


def test_friction_is_named_by_a_few_tosses(
    recordings: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    if not (recordings / FOLDER / "tosses.npz").is_file():
        pytest.skip(f"there is no {FOLDER} in {recordings}")
    result = studied(recordings, first=300, fitted=8, judged=4)
    figures = headline(result)["figures"]
    # Of eight tosses the mean error is known to a third: friction, to which it is as the square
    # of the way, to a quarter.
    assert figures["friction"] == pytest.approx(PUBLISHED, rel=0.25)
    assert figures["found_as_described"] == 0
    with pytest.raises(SystemExit):
        main(["--fitted", "1"])
    assert "at least 4" in capsys.readouterr().err
    assert json.dumps(result)
