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

SEED = 1
"""Of a case of the pendulum whose effect has bounds: its sizes take most chance."""
CASE = make_cases(1, SEED, clean=False)[0]
CARTPOLE = Case(
    name="cartpole", seed=2, robot="cartpole", effect="viscous_friction", kind="joint",
    place="hinge",
)  # fmt: skip
CLEAN = Case(name="clean", seed=5, robot="pendulum", effect=None, kind=None, place=None)
BIASED = replace(CLEAN, name="biased", effect="sensor_bias", kind="sensor", place="hinge.position")


@pytest.fixture(scope="module")
def many(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with several cases, made together; three of them share a robot."""
    folder = tmp_path_factory.mktemp("cases")
    generate([CLEAN, CASE, CARTPOLE, BIASED], folder)
    return folder


@pytest.fixture(scope="module")
def made(many: Path) -> Path:
    """Return the folder of the case of `SEED`."""
    return many / CASE.name


def test_the_seal_lies_outside_the_recordings(made: Path) -> None:
    told = sorted(p.name for p in (made / "recordings").iterdir())
    assert told == [f"episode_{i}.csv.gz" for i in range(1, 6)] + ["recording.toml"]
    assert (made / "sealed" / "truth.sealed.json").is_file()


def test_the_recordings_are_what_morph_reads(many: Path) -> None:
    folder = many / CARTPOLE.name / "recordings"
    episodes = load_recordings(folder, robot=load("cartpole"))
    assert [episode.session for episode in episodes] == ["first"] * 3 + ["second"] * 2
    for episode in episodes:
        assert set(episode.channels) == {"slide.position", "hinge.position", "slide.command"}
        assert 7.9 < episode.seconds <= 8.0
        assert episode.channel("slide.command").hold
        assert not episode.notes


def test_the_same_seed_gives_the_same_bytes_alone_and_in_company(
    made: Path, tmp_path: Path
) -> None:
    conceal(SEED, tmp_path)
    for path in sorted(p for p in made.rglob("*") if p.is_file()):
        assert path.read_bytes() == (tmp_path / path.relative_to(made)).read_bytes()


def test_the_seal_opens_with_what_was_asked(made: Path) -> None:
    sealed = open_seal(made)
    assert sealed.case == CASE
    assert 3 <= sealed.strength <= 60
    ratios = [sealed.true[k] / sealed.nominal[k] for k in MECHANISMS[sealed.case.robot].varied]
    assert all(0.9 <= ratio <= 1.1 and ratio != 1 for ratio in ratios)


def test_a_clean_case_hides_nothing(many: Path) -> None:
    sealed = open_seal(many / CLEAN.name)
    assert (sealed.parameters, sealed.strength) == ({}, 0.0)


def test_a_biased_sensor_reads_off_by_its_bias(many: Path) -> None:
    sealed = open_seal(many / BIASED.name)
    # The first episode starts at rest at 0; noise of one step on the first reading.
    data = np.genfromtxt(many / BIASED.name / "recordings" / "episode_1.csv.gz", delimiter=",",
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
