"""Concealed cases on disk: what is written, what is sealed, what is drawn."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from experiments.conceal import Case, conceal, generate, make_cases, open_seal
from experiments.conceal.laws import LAWS
from experiments.conceal.mechanisms import MECHANISMS
from experiments.conceal.seal import SealError
from morph.body.load import load
from morph.record.load import load as load_recordings


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with one small case."""
    folder = tmp_path_factory.mktemp("case")
    conceal(7, folder)
    return folder


def test_the_seal_lies_outside_the_recordings(made: Path) -> None:
    told = sorted(p.name for p in (made / "recordings").iterdir())
    assert told == [f"episode_{i}.csv.gz" for i in range(1, 6)] + ["recording.toml"]
    assert (made / "sealed" / "truth.sealed.json").is_file()


def test_the_recordings_are_what_morph_reads(tmp_path: Path) -> None:
    case = Case(
        name="c", seed=2, robot="cartpole", effect="viscous_friction", kind="joint", place="hinge"
    )
    conceal(case, tmp_path)
    episodes = load_recordings(tmp_path / "recordings", robot=load("cartpole"))
    assert [episode.session for episode in episodes] == ["first"] * 3 + ["second"] * 2
    for episode in episodes:
        assert set(episode.channels) == {"slide.position", "hinge.position", "slide.command"}
        assert 7.9 < episode.seconds <= 8.0
        assert episode.channel("slide.command").hold
        assert not episode.notes


def test_the_same_seed_gives_the_same_bytes(made: Path, tmp_path: Path) -> None:
    conceal(7, tmp_path)
    for path in sorted(p for p in made.rglob("*") if p.is_file()):
        assert path.read_bytes() == (tmp_path / path.relative_to(made)).read_bytes()


def test_the_seal_opens_with_what_was_asked(made: Path) -> None:
    sealed = open_seal(made)
    assert sealed.case == make_cases(1, 7, clean=False)[0]
    assert 3 <= sealed.strength <= 60
    ratios = [sealed.true[k] / sealed.nominal[k] for k in MECHANISMS[sealed.case.robot].varied]
    assert all(0.9 <= ratio <= 1.1 and ratio != 1 for ratio in ratios)


def test_a_case_is_the_same_in_any_company(made: Path, tmp_path: Path) -> None:
    case = open_seal(made).case
    other = replace(case, name="other", seed=11)
    generate([other, case], tmp_path)
    told = made / "recordings" / "episode_1.csv.gz"
    again = tmp_path / case.name / "recordings" / "episode_1.csv.gz"
    assert told.read_bytes() == again.read_bytes()


def test_a_clean_case_hides_nothing(tmp_path: Path) -> None:
    case = Case(name="c", seed=5, robot="pendulum", effect=None, kind=None, place=None)
    sealed = conceal(case, tmp_path)
    assert (sealed.parameters, sealed.strength) == ({}, 0.0)


def test_a_biased_sensor_reads_off_by_its_bias(tmp_path: Path) -> None:
    case = Case(name="c", seed=5, robot="pendulum", effect="sensor_bias", kind="sensor",
                place="hinge.position")  # fmt: skip
    sealed = conceal(case, tmp_path / "a")
    # The first episode starts at rest at 0; noise of one step on the first reading.
    data = np.genfromtxt(tmp_path / "a" / "recordings" / "episode_1.csv.gz", delimiter=",",
                         names=True, deletechars="")  # fmt: skip
    first = data["hinge.position"][0]
    assert abs(first - sealed.parameters["bias"]) < 5 * sealed.noise["hinge.position"]


def test_a_missing_seal_is_named(tmp_path: Path) -> None:
    with pytest.raises(SealError, match=r"truth\.sealed\.json.*cannot open"):
        open_seal(tmp_path)


def test_every_law_is_hidden_equally_often() -> None:
    cases = make_cases(60, 1, clean=False)
    assert [sum(c.effect == law for c in cases) for law in LAWS] == [6] * 10
    assert cases == make_cases(60, 1, clean=False)
    assert all(c.effect is None and c.place is None for c in make_cases(5, 1, clean=True))
