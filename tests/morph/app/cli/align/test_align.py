from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import jsonschema
import numpy as np
import pytest

import morph.app.report.align
from morph.alignment.maps.files import read
from morph.app.cli.main import main

SCHEMA = json.loads(
    (Path(morph.app.report.align.__file__).parent / "align.schema.json").read_text()
)
MESSAGE = re.compile(r"error: (?P<where>.+?): (?P<what>.+)\n  fix: (?P<fix>.+)\n")
BODIES = ("cartpole", "rider_rigid_driven")


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "80")


def record(out: str = "out") -> dict[str, Any]:
    said: dict[str, Any] = json.loads((Path(out) / "align.json").read_text())
    jsonschema.validate(said, SCHEMA)
    return said


def content() -> dict[str, bytes]:
    return {str(path): path.read_bytes() for path in Path().rglob("*") if path.is_file()}


def refused(capsys: pytest.CaptureFixture[str], *words: str) -> re.Match[str]:
    before = content()
    assert main(["align", *words]) == 2
    told = capsys.readouterr()
    assert told.out == ""
    found = MESSAGE.fullmatch(told.err)
    assert found, told.err
    assert content() == before
    return found


def linear(rows: int, rng: np.random.Generator, A: np.ndarray, B: np.ndarray) -> dict[str, Any]:
    """Return transitions of x' = A x + B u, each from a state of its own."""
    state, command = rng.normal(size=(rows, len(A))), rng.normal(size=(rows, B.shape[1]))
    return {"state": state, "command": command, "after": state @ A.T + command @ B.T}


def files() -> None:
    """Write a source, and a target that is the source with its numbers turned and swapped."""
    A, B = np.array([[0.9, 0.2], [0.0, 0.5]]), np.array([[0.0], [1.0]])
    np.savez("a.npz", **linear(200, np.random.default_rng(0), A, B))
    # y = (-x_2, x_1): the second number of the target is the first of the source.
    turn = np.array([[0.0, -1.0], [1.0, 0.0]])
    seen = linear(200, np.random.default_rng(1), turn @ A @ turn.T, -2.0 * turn @ B)
    names: dict[str, Any] = {
        "state_names": np.array(["lean", "place"]),
        "command_names": np.array(["wheel"]),
    }
    np.savez("b.npz", **seen, **names)


def test_the_parts_are_told_with_arrows_and_signs(capsys: pytest.CaptureFixture[str]) -> None:
    status = main(["align", *BODIES, "--samples", "100", "--out", "out", "--quiet"])
    told = capsys.readouterr()
    said = record()
    assert status == (3 if said["guard"]["verdict"] == "unsafe" else 0)
    assert told.out.startswith("rider_rigid_driven is seen as cartpole\n")
    # The rider's ankle turns the other way round than the cart-pole's hinge: their axes.
    assert re.search(r"  board  =+>  slide  \+\d+ %\n  ankle  -+>  hinge  -\d+ %\n", told.out)
    assert max(map(len, told.out.splitlines())) <= 80
    arrows = {(a["from"], a["to"]): a["weight"] for a in said["parts"]["states"]}
    assert arrows[("ankle", "hinge")] < -0.9
    assert arrows[("board", "slide")] > 0.9
    assert {path.name for path in Path("out").iterdir()} == {
        *("align.json", "report.html", "maps", ".morph.files")
    }
    assert read(Path("out") / said["map"]).kind == said["kind"]


def test_without_a_folder_nothing_is_written(capsys: pytest.CaptureFixture[str]) -> None:
    main(["align", *BODIES, "--samples", "20", "--json", "--quiet"])
    jsonschema.validate(json.loads(capsys.readouterr().out), SCHEMA)
    assert content() == {}


def test_the_same_seed_gives_the_same_map(capsys: pytest.CaptureFixture[str]) -> None:
    for out in ("one", "two"):
        main(["align", *BODIES, "--samples", "20", "--out", out, "--quiet"])
    same = [{**record(out), "seconds": 0.0} for out in ("one", "two")]
    assert same[0] == same[1]
    assert Path("one/maps/01_body_map.npz").read_bytes() == (
        Path("two/maps/01_body_map.npz").read_bytes()
    )


def test_recordings_of_other_bodies_are_aligned_by_their_own_names(
    capsys: pytest.CaptureFixture[str],
) -> None:
    files()
    words = ["--source", "a.npz", "--target", "b.npz", "--map", "transition", "--out", "out"]
    assert main(["align", *words, "--quiet"]) == 0
    said = record()
    found = {(a["from"], a["to"]): a["weight"] for a in said["parts"]["states"]}
    # The target was made by a turn: nothing but these two arrows is in it.
    assert found == {
        ("place", "state 1"): pytest.approx(1.0, abs=0.02),
        ("lean", "state 2"): pytest.approx(-1.0, abs=0.02),
    }
    assert [(a["from"], a["to"]) for a in said["parts"]["commands"]] == [("command 1", "wheel")]
    assert said["parts"]["commands"][0]["weight"] == pytest.approx(-1.0)
    assert said["quality"]["one_step"] < 1e-3
    assert said["guard"]["verdict"] == "unsure"
    # The negative of all states and commands moves alike.
    assert said["notes"][-1] == "all signs together may be turned round: no pairs tell them"
    assert said["samples"] == {"source": 160, "target": 160, "held_out": 40}


def test_an_alignment_is_replaced_only_when_that_is_asked_for(
    capsys: pytest.CaptureFixture[str],
) -> None:
    files()
    words = ("--source", "a.npz", "--target", "b.npz", "--out", "out", "--quiet")
    assert main(["align", *words]) == 0
    capsys.readouterr()
    assert refused(capsys, *words)["what"] == "the folder holds an alignment already"
    assert main(["align", *words, "--seed", "4", "--fresh"]) == 0
    assert record()["seed"] == 4


@pytest.mark.parametrize(
    ("words", "where", "what"),
    [
        (("cartpole",), "morph align", "1 bodies and 0 files are named"),
        ((*BODIES, "pendulum"), "morph align", "3 bodies and 0 files are named"),
        ((*BODIES, "--samples", "9"), "--samples", "9 transitions tell nothing of a body"),
        ((*BODIES, "--samples", "100001"), "--samples", "100001 transitions would take longer"),
        (("pendulum", "cartpole"), "body pendulum", "it shares no quantity of balance"),
        ((*BODIES, "--seed", "-1"), "--seed", "-1 is no seed"),
        ((*BODIES, "--map", "transitoin"), "--map", "there is no map 'transitoin'"),
        ((*BODIES, "--task", "swim"), "--task", "swim is not about a state of rest"),
        (("cartpole", "swimmer_three_links"), "body swimmer_three_links", "it shares no quantity"),
        (("cartpole", "--target", "no.npz"), "--target no.npz", "it cannot be read"),
        ((*BODIES, "--out", "mine.txt"), "mine.txt", "this is a file"),
    ],
)
def test_what_cannot_be_used_is_refused(
    capsys: pytest.CaptureFixture[str], words: tuple[str, ...], where: str, what: str
) -> None:
    Path("mine.txt").write_text("mine")
    found = refused(capsys, *words)
    assert found["where"] == where
    assert found["what"].startswith(what)


def broken(**changed: Any) -> dict[str, Any]:
    known = {"state": np.ones((20, 2)), "command": np.ones((20, 1)), "after": np.ones((20, 2))}
    return {name: value for name, value in (known | changed).items() if value is not None}


@pytest.mark.parametrize(
    ("arrays", "what"),
    [
        (broken(after=None), "it lacks after"),
        (broken(more=np.ones(2)), "it holds 'more', which says nothing here"),
        (broken(command=np.ones(20)), "command is of type float64 and shape (20,)"),
        (broken(state=np.array([["a", "b"]] * 20)), "state is of type <U1 and shape (20, 2)"),
        (broken(after=np.ones((19, 2))), "state, command, after and turns have the shapes"),
        (broken(state=np.full((20, 2), np.nan)), "state holds numbers that are not finite"),
        (broken(state_names=np.array(["a"])), "state_names holds 1 texts for 2 columns"),
        (broken(state_names=np.array(["a", "a"])), "state_names holds 2 texts for 2 columns"),
        (broken(state=np.array([{}] * 20)), "it cannot be read"),
        (
            {name: value[:8] for name, value in broken().items()},
            "it holds 8 transitions",
        ),
    ],
)
def test_a_file_that_holds_something_else_is_refused(
    capsys: pytest.CaptureFixture[str], arrays: dict[str, Any], what: str
) -> None:
    np.savez("odd.npz", **arrays)
    found = refused(capsys, "cartpole", "--target", "odd.npz", "--quiet")
    assert found["what"].startswith(what)


def test_a_body_that_never_moved_teaches_nothing(capsys: pytest.CaptureFixture[str]) -> None:
    np.savez("still.npz", **broken())
    found = refused(capsys, "cartpole", "--target", "still.npz", "--quiet")
    assert found["where"].startswith("map ")


def test_a_map_that_needs_a_task_is_refused_where_there_is_none(
    capsys: pytest.CaptureFixture[str],
) -> None:
    files()
    found = refused(capsys, "cartpole", "--target", "b.npz", "--map", "task", "--quiet")
    assert found["where"] == "--map task"
