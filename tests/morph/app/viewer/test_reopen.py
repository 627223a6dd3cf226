from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import jsonschema
import pytest

from morph.app.viewer import state
from morph.app.viewer.camera import Camera
from morph.app.viewer.reopen import MOST_BYTES, read_state
from morph.app.viewer.state import BodyRequest, Saved, Sources
from morph.errors import ViewError

SCHEMA = json.loads(Path(state.__file__).with_name("view.schema.json").read_text(encoding="utf-8"))

SAW = Saved(
    given=Sources(
        bodies=(
            BodyRequest(asked="cartpole", sha256="ab"),
            BodyRequest(asked="/bodies/mine.urdf", sha256=""),
        ),
        base="floating",
        task="balance",
        policies=("learned", "/policies/one"),
        recordings=("/recordings/a.csv",),
        seconds=2.5,
        seed=7,
    ),
    view="compare",
    views={"compare": {"task": "balance"}, "design": {}},
    time=1.25,
    speed=0.25,
    playing=False,
    repeat=False,
    camera=Camera(position=(1.0, -2.0, 0.5), look_at=(0.0, 0.0, 0.25)),
    hidden=("contact",),
    follow=False,
)


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return tmp_path / "view.json"


def written(file: Path, value: Any) -> Path:
    file.write_text(json.dumps(value), encoding="utf-8")
    return file


def changed(place: str, value: Any) -> Any:
    whole = json.loads(SAW.text())
    part = whole
    *above, last = place.split(".")
    for name in above:
        part = part[int(name) if name.isdigit() else name]
    part[int(last) if last.isdigit() else last] = value
    return whole


@pytest.mark.parametrize("saw", [SAW, Saved(given=Sources(), view="align")])
def test_what_is_read_is_what_was_written(file: Path, saw: Saved) -> None:
    file.write_text(saw.text(), encoding="utf-8")
    assert read_state(file) == saw


@pytest.mark.parametrize("saw", [SAW, Saved(given=Sources(), view="align")])
def test_what_is_written_is_by_its_own_schema(saw: Saved) -> None:
    jsonschema.validate(json.loads(saw.text()), SCHEMA)


def test_a_package_is_shown_again_and_older_files_say_nothing_of_one(file: Path) -> None:
    packed = replace(SAW, given=replace(SAW.given, package="/made/arm"))
    file.write_text(packed.text(), encoding="utf-8")
    assert read_state(file) == packed
    older = json.loads(SAW.text())
    del older["given"]["package"]
    jsonschema.validate(older, SCHEMA)
    assert read_state(written(file, older)).given.package is None


def test_paths_are_relative_to_the_folder_of_the_file(file: Path) -> None:
    saw = replace(
        SAW,
        given=Sources(
            bodies=(
                BodyRequest(asked="cartpole", sha256=""),
                BodyRequest(asked="bodies/mine.urdf", sha256=""),
            ),
            policies=("learned", "kept"),
            recordings=("a.csv",),
            root="data",
            folder="bodies",
            diagnosis="found",
            transfer="carried",
        ),
    )
    file.write_text(saw.text(), encoding="utf-8")
    given, folder = read_state(file).given, file.parent
    # A name on the shelf stays a name, and `learned` is none of a folder.
    assert [body.asked for body in given.bodies] == ["cartpole", str(folder / "bodies/mine.urdf")]
    assert given.policies == ("learned", str(folder / "kept"))
    assert given.files == tuple(
        str(folder / each)
        for each in ("bodies/mine.urdf", "kept", "a.csv", "bodies", "data", "found", "carried")
    )


WRONG = [
    ("schema", "morph.view/2", r"schema is \"morph.view/2\""),
    ("view", "compere", r"view is \"compere\""),
    ("views.compere", {}, r"'views.compere', which is not known"),
    ("views.compare", [], r"views.compare is \[\]"),
    ("extra", 1, r"'extra', which is not known"),
    ("clock.tine", 1, r"'clock.tine', which is not known"),
    ("clock.time", -1.0, r"clock.time is -1.0"),
    ("clock.time", "1", r"clock.time is \"1\""),
    ("clock.time", True, r"clock.time is true"),
    ("clock.speed", 3.0, r"clock.speed is 3.0"),
    ("clock.playing", 1, r"clock.playing is 1"),
    ("camera.position", [0.0, 0.0], r"camera.position is"),
    ("camera.position", [0.0, 0.0, 1e9], r"camera.position is"),
    ("camera.look_at", [1.0, -2.0, 0.5], r"camera.look_at is \[1.0, -2.0, 0.5\]"),
    ("camera.roll", 0.0, r"'camera.roll', which is not known"),
    ("given.seed", -1, r"given.seed is -1"),
    ("given.seed", 1.5, r"given.seed is 1.5"),
    ("given.task", 3, r"given.task is 3"),
    ("given.task", "a\0b", r"given.task is"),
    ("given.bodies.0", "cartpole", r"given.bodies is"),
    ("given.bodies.0.asked", "", r"given.bodies\[0\].asked is"),
    ("given.bodies", [{"asked": "a", "sha256": ""}] * 65, r"given.bodies is"),
    ("given.policies", "learned", r"given.policies is"),
    ("hidden_arrows", [1], r"hidden_arrows is"),
    ("follow", None, r"follow is null"),
]


@pytest.mark.parametrize(("place", "value", "what"), WRONG)
def test_a_value_that_does_not_fit_is_named_with_its_place(
    file: Path, place: str, value: Any, what: str
) -> None:
    with pytest.raises(ViewError, match=what):
        read_state(written(file, changed(place, value)))


def test_an_unknown_name_is_told_with_the_nearest(file: Path) -> None:
    with pytest.raises(ViewError, match=r"name it as meant: 'follow'"):
        read_state(written(file, changed("folow", True)))


@pytest.mark.parametrize("name", ["schema", "given", "clock", "camera", "follow"])
def test_what_is_missing_is_named(file: Path, name: str) -> None:
    whole = json.loads(SAW.text())
    del whole[name]
    with pytest.raises(ViewError, match=rf"it lacks '{name}'"):
        read_state(written(file, whole))


@pytest.mark.parametrize(
    ("data", "what"),
    [
        (b"", r"it is no JSON"),
        (b"\xff\xfe", r"it is no JSON"),
        (b"[" * 100_000, r"it is no JSON"),
        (b"[]", r"it holds \[\]"),
        (b'{"schema": NaN}', r"NaN is no number of JSON"),
        (b" " * (MOST_BYTES + 1), r"1000000 are read at most"),
        (b'{"schema": "morph.view/1", "morph": ' + b"9" * 5000 + b"}", r"it is no JSON|morph is"),
    ],
)
def test_a_file_of_something_else_is_refused_in_a_sentence(
    file: Path, data: bytes, what: str
) -> None:
    file.write_bytes(data)
    with pytest.raises(ViewError, match=what):
        read_state(file)


def test_a_folder_or_nothing_is_no_saved_view(tmp_path: Path) -> None:
    with pytest.raises(ViewError, match=r"it is a folder, no file"):
        read_state(tmp_path)
    with pytest.raises(ViewError, match=r"No such file"):
        read_state(tmp_path / "none.json")
