"""A command's folder: nothing of a user's is replaced or removed in it, and all of its own is."""

from __future__ import annotations

from pathlib import Path

import pytest

from morph.app.cli.outputs import (
    ALIGN,
    LEARN,
    LOOP,
    TRANSFER,
    Outputs,
    check_out,
    claim,
    clear,
)
from morph.errors import OutputError
from morph.run_folder import OWNED

EVERY = (LEARN, LOOP, ALIGN, TRANSFER)


def write(out: Path, patterns: tuple[str, ...]) -> list[Path]:
    """Write a file for each pattern, and return them."""
    files = [out / each.replace("[0-9]", "0").replace("*", "1") for each in patterns]
    for each in files:
        each.parent.mkdir(parents=True, exist_ok=True)
        each.write_text("content")
    return files


@pytest.mark.parametrize("outputs", EVERY, ids=lambda each: each.command)
def test_what_a_command_wrote_is_removed_and_what_a_user_wrote_stays(
    outputs: Outputs, tmp_path: Path
) -> None:
    claim(tmp_path, outputs, results=True)
    write(tmp_path, (*outputs.results, *outputs.progress))
    mine = write(tmp_path, ("notes.txt", f"{Path(outputs.results[-1]).parent}/mine.txt"))
    check_out(str(tmp_path), outputs)
    clear(tmp_path, outputs, progress=True)
    assert sorted(each for each in tmp_path.rglob("*") if each.is_file()) == sorted(mine)


@pytest.mark.parametrize("outputs", EVERY, ids=lambda each: each.command)
def test_a_user_s_file_under_any_name_of_a_result_is_refused(
    outputs: Outputs, tmp_path: Path
) -> None:
    for pattern in outputs.results:
        out = tmp_path / pattern.replace("/", "_")
        claim(out, outputs, results=False)
        write(out, outputs.progress)
        check_out(str(out), outputs)
        if pattern in outputs.progress:
            continue
        (mine,) = write(out, (pattern,))
        with pytest.raises(OutputError, match="did not write this"):
            check_out(str(out), outputs)
        clear(out, outputs, progress=True)
        assert mine.read_text() == "content"


@pytest.mark.parametrize("outputs", EVERY, ids=lambda each: each.command)
def test_results_are_removed_without_what_a_command_resumes_from(
    outputs: Outputs, tmp_path: Path
) -> None:
    claim(tmp_path, outputs, results=True)
    write(tmp_path, outputs.results)
    progress = write(tmp_path, outputs.progress)
    clear(tmp_path, outputs, progress=False)
    left = {each for each in tmp_path.rglob("*") if each.is_file()} - {tmp_path / OWNED}
    assert left == set(progress)
    # What it resumes from is still known as the command's own.
    check_out(str(tmp_path), outputs)


def test_a_folder_of_another_command_is_refused(tmp_path: Path) -> None:
    claim(tmp_path, LOOP, results=True)
    write(tmp_path, LOOP.results)
    with pytest.raises(OutputError, match="holds nothing of morph transfer"):
        check_out(str(tmp_path), TRANSFER)


@pytest.mark.parametrize("kind", ["file", "link"])
def test_a_folder_s_name_that_is_taken_is_refused_and_no_link_is_followed(
    kind: str, tmp_path: Path
) -> None:
    out, elsewhere = tmp_path / "out", tmp_path / "elsewhere"
    claim(out, LEARN, results=True)
    (mine,) = write(elsewhere, ("policy.json",))
    if kind == "file":
        (out / "policy").write_text("mine")
    else:
        (out / "policy").symlink_to(elsewhere)
    with pytest.raises(OutputError, match="did not write this"):
        check_out(str(out), LEARN)
    assert mine.read_text() == "content"
