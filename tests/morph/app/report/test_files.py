import json
from dataclasses import replace
from pathlib import Path

import jsonschema
import numpy as np
import pytest

from morph.app.report import files
from morph.app.report.files import FILES, write_diagnosis
from morph.errors import OutputError
from morph.model.diagnosis import Diagnosis

SCHEMA = json.loads((Path(files.__file__).parent / "diagnosis.schema.json").read_text())


def names(folder: Path) -> set[str]:
    return {path.name for path in folder.iterdir()}


@pytest.mark.parametrize("which", ["mismatch", "consistent", "unknown"])
def test_what_is_written_follows_the_schema(
    which: str, request: pytest.FixtureRequest, tmp_path: Path
) -> None:
    write_diagnosis(request.getfixturevalue(which), tmp_path / "out")
    written = json.loads((tmp_path / "out" / "diagnosis.json").read_text())
    jsonschema.Draft202012Validator.check_schema(SCHEMA)
    jsonschema.Draft202012Validator(SCHEMA).validate(written)
    assert written["verdict"] == which


def test_the_schema_refuses_a_mismatch_that_names_nothing(mismatch: Diagnosis) -> None:
    content = {**mismatch.as_json(), "findings": []}
    with pytest.raises(jsonschema.ValidationError, match="should be non-empty"):
        jsonschema.Draft202012Validator(SCHEMA).validate(content)


def test_a_mismatch_is_written_with_all_its_files_and_nothing_is_left_beside(
    mismatch: Diagnosis, tmp_path: Path
) -> None:
    out = tmp_path / "a" / "b" / "out"
    write_diagnosis(mismatch, out)
    assert names(out) == set(FILES)
    assert names(out.parent) == {"out"}
    assert out.stat().st_mode & 0o777 == 0o755
    # The delay is none of MuJoCo's.
    lacks = "<!-- It lacks actuator_delay@elbow: see corrected.toml. -->"
    assert (out / "corrected.xml").read_text().splitlines() == [lacks, "<mujoco/>"]
    assert "elbow" in (out / "corrected.toml").read_text()
    with np.load(out / "residual.npz") as residual:
        assert residual["weights"].tolist() == [0.0, 1.0, 2.0, 3.0, 4.0, 5.0]


def test_the_same_diagnosis_is_written_with_the_same_bytes(
    mismatch: Diagnosis, tmp_path: Path
) -> None:
    for name in ("one", "two"):
        write_diagnosis(mismatch, tmp_path / name)
    for name in FILES:
        assert (tmp_path / "one" / name).read_bytes() == (tmp_path / "two" / name).read_bytes()


def test_no_correction_of_an_earlier_diagnosis_survives_and_other_files_do(
    mismatch: Diagnosis, consistent: Diagnosis, tmp_path: Path
) -> None:
    out = tmp_path / "out"
    write_diagnosis(mismatch, out)
    (out / "my notes.txt").write_text("keep")
    write_diagnosis(consistent, out)
    assert names(out) == {"diagnosis.json", "report.html", "my notes.txt"}
    assert json.loads((out / "diagnosis.json").read_text())["verdict"] == "consistent"
    assert names(tmp_path) == {"out"}


def test_the_folder_where_one_stands_is_refused_since_it_is_replaced_whole(
    consistent: Diagnosis, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "out").mkdir()
    monkeypatch.chdir(tmp_path / "out")
    for out in (Path(), Path("../out")):
        with pytest.raises(OutputError, match=r"the folder where you stand"):
            write_diagnosis(consistent, out)
    write_diagnosis(consistent, Path("in it"))
    assert names(tmp_path / "out") == {"in it"}


def test_a_home_with_a_diagnosis_in_it_is_not_replaced(
    consistent: Diagnosis, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    home = tmp_path / "home"
    (home / "me").mkdir(parents=True)
    (home / "diagnosis.json").write_text('{"schema": "morph.diagnosis/1"}')
    monkeypatch.setenv("HOME", str(home / "me"))
    with pytest.raises(OutputError, match=r"your home lies in this folder"):
        write_diagnosis(consistent, home)
    assert names(home) == {"diagnosis.json", "me"}


@pytest.mark.parametrize("stop", [KeyboardInterrupt(), OSError(28, "No space left on device")])
@pytest.mark.parametrize("before", [False, True])
def test_a_run_that_stops_midway_leaves_what_was_there(
    stop: BaseException,
    before: bool,
    mismatch: Diagnosis,
    consistent: Diagnosis,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    out = tmp_path / "out"
    if before:
        write_diagnosis(consistent, out)
    old = {p.name: p.read_bytes() for p in out.iterdir()} if before else {}
    written = files.write_whole

    def fails_at_the_last(path: Path, content: str | bytes) -> Path:
        if path.name == "diagnosis.json":
            raise stop
        return written(path, content)

    monkeypatch.setattr(files, "write_whole", fails_at_the_last)
    expected = OutputError if isinstance(stop, OSError) else KeyboardInterrupt
    with pytest.raises(expected):
        write_diagnosis(mismatch, out)
    assert names(tmp_path) == ({"out"} if before else set())
    assert ({p.name: p.read_bytes() for p in out.iterdir()} if before else {}) == old


def test_a_folder_that_holds_something_else_is_refused(
    consistent: Diagnosis, tmp_path: Path
) -> None:
    (tmp_path / "thesis.tex").write_text("precious")
    with pytest.raises(OutputError, match="holds no earlier diagnosis") as refusal:
        write_diagnosis(consistent, tmp_path)
    assert refusal.value.where == str(tmp_path)
    assert "diagnosis.json" in refusal.value.fix
    assert names(tmp_path) == {"thesis.tex"}


def test_a_user_s_own_file_of_that_name_is_no_earlier_diagnosis(
    consistent: Diagnosis, tmp_path: Path
) -> None:
    (tmp_path / "diagnosis.json").write_text('{"patient": "me"}')
    with pytest.raises(OutputError, match="holds no earlier diagnosis"):
        write_diagnosis(consistent, tmp_path)
    assert (tmp_path / "diagnosis.json").read_text() == '{"patient": "me"}'


def test_a_file_is_refused(consistent: Diagnosis, tmp_path: Path) -> None:
    (tmp_path / "out").write_text("precious")
    with pytest.raises(OutputError, match="this is a file or a link, and a diagnosis is a folder"):
        write_diagnosis(consistent, tmp_path / "out")
    assert (tmp_path / "out").read_text() == "precious"


def test_a_folder_under_a_file_is_refused(consistent: Diagnosis, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("precious")
    with pytest.raises(OutputError, match="nothing can be written"):
        write_diagnosis(consistent, tmp_path / "file" / "out")


def test_the_error_of_a_simulation_that_blew_up_is_null(
    mismatch: Diagnosis, tmp_path: Path
) -> None:
    rmse = {**mismatch.held_out_rmse, "nominal": {"elbow.position": float("inf")}}
    write_diagnosis(replace(mismatch, held_out_rmse=rmse), tmp_path / "out")
    written = json.loads((tmp_path / "out" / "diagnosis.json").read_text())
    assert written["fit"]["held_out_rmse"]["nominal"] == {"elbow.position": None}
    jsonschema.Draft202012Validator(SCHEMA).validate(written)


def test_a_number_that_is_not_finite_elsewhere_is_an_error_and_nothing_is_written(
    mismatch: Diagnosis, tmp_path: Path
) -> None:
    with pytest.raises(OutputError, match="the diagnosis holds what JSON cannot"):
        write_diagnosis(replace(mismatch, improvement_low90=float("nan")), tmp_path / "out")
    assert names(tmp_path) == set()


def test_a_residual_that_would_need_a_pickle_is_refused(
    mismatch: Diagnosis, tmp_path: Path
) -> None:
    hiding = np.array([{"a": 1}], dtype=object)
    with pytest.raises(OutputError, match="the learned residual's weights is no array"):
        write_diagnosis(replace(mismatch, residual={"weights": hiding}), tmp_path / "out")
