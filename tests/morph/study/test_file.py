from __future__ import annotations

import os
from pathlib import Path

import pytest

from morph.errors import StudyError
from morph.study import file as module
from morph.study.file import load_study

HEAD = 'function = "toy_cells:square"\n'


MANY = "".join(f"x{i} = 1\n" for i in range(1001))


def cases(folder: Path, text: str) -> list[dict[str, object]]:
    path = folder / "squares.toml"
    path.write_text(HEAD + text)
    return [dict(cell.case) for cell in load_study(path).cells]


def test_cells_are_the_cases_one_by_one_then_the_product(tmp_path: Path) -> None:
    told = cases(tmp_path, '[[cell]]\nx = 7\n[grid]\nfactor = [1, 2.5]\nx = "-1:2"\n')
    assert told == [{"x": 7}] + [{"factor": f, "x": x} for f in (1, 2.5) for x in (-1, 0, 1)]


def test_the_name_is_the_file_s_unless_it_says_another(tmp_path: Path) -> None:
    path = tmp_path / "squares.toml"
    path.write_text(HEAD + "[grid]\nx = [1]\n")
    assert load_study(path).name == "squares"
    path.write_text('name = "other"\n' + HEAD + "[grid]\nx = [1]\n")
    assert load_study(path).name == "other"


def test_data_lie_beside_the_file(tmp_path: Path) -> None:
    path = tmp_path / "squares.toml"
    path.write_text(HEAD + 'data = ["a/masses.csv"]\n[grid]\nx = [1]\n')
    assert load_study(path).cells[0].data == (tmp_path / "a/masses.csv",)
    assert load_study(path).path == (tmp_path, Path.cwd())


@pytest.mark.parametrize(
    ("text", "what"),
    [
        ("", "no cells"),
        ("cell = []\n", "no cells"),
        ("[[cel]]\nx = 1\n", "unknown key 'cel'\n.*write 'cell'"),
        ("cell = 3\n", "`cell` is no list of tables"),
        ("grid = 3\n", "`grid` is no table"),
        ("[grid]\n", "`grid` is no table"),
        ("[grid]\nx = []\n", r"grid\.x = \[\] holds no values"),
        ("[grid]\nx = 1\n", r"grid\.x = 1 holds no values"),
        ('[grid]\nx = "1:1"\n', r"grid\.x = '1:1' holds no values"),
        ('[grid]\nx = "one"\n', r"grid\.x = 'one' holds no values"),
        ('[grid]\nx = "0:1000000000000"\n', "1000000000000 values"),
        ('[grid]\nx = "0:1001"\ny = "0:100"\n', "100100 cells"),
        ('[[cell]]\nx = 1\n[grid]\nx = "0:100000"\n', "100001 cells"),
        (f"cell = [{'{},' * 100_001}]\n", "100001 cells"),
        (f"[grid]\nx = [{'1,' * 100_001}]\n", "100001 cells"),
        ("[[cell]]\n" + MANY, "a cell has 1001 entries"),
        ("[grid]\n" + MANY, "`grid` has 1001 lists"),
        ("data = [" + '"a",' * 1001 + "]\n[grid]\nx = [1]\n", "data names 1001 files"),
        # Each of 60,000 cases: 1 + 1002 letters of x with its quotation marks, 1 + 5 of y.
        (
            f'[grid]\nx = ["{"a" * 1000}"]\ny = "0:60000"\n',
            r"the cases of the grid have up to 60540000 letters",
        ),
        (f"[[cell]]\nx = 0x{'f' * 5000}\n", r"case\.x is a int: 20000 bits"),
        (f"[grid]\nx = 0x{'f' * 5000}\n", r"grid\.x = an integer of thousands of digits holds"),
        (f"[grid]\nx = [0x{'f' * 5000}]\n", r"case\.x is a int: 20000 bits"),
        (f"name = 0x{'f' * 5000}\n[grid]\nx = [1]\n", "name = an integer of thousands of digits"),
        ("[grid]\nx = [nan]\n", r"case\.x is a float: nan"),
        ("[grid]\nx = [2026-11-23]\n", r"case\.x is a date"),
        ("name = 3\n[grid]\nx = [1]\n", "name = 3 is no text"),
        ('name = "../up"\n[grid]\nx = [1]\n', r"name = '\.\./up'\n.*use letters"),
        ('data = "a.csv"\n[grid]\nx = [1]\n', "data = 'a.csv' is no list of paths"),
    ],
)
def test_what_is_not_understood_is_named_with_the_file(
    tmp_path: Path, text: str, what: str
) -> None:
    with pytest.raises(StudyError, match=rf"squares\.toml: .*{what}"):
        cases(tmp_path, text)


@pytest.mark.parametrize(
    ("text", "what"),
    [
        ("[grid]\nx = [1]\n", 'no function\n.*write function = "'),
        ("function = 3\n[grid]\nx = [1]\n", "function = 3 is no text"),
        ('function = "square"\n[grid]\nx = [1]\n', "'square' names no function"),
        ("function", "cannot be read: "),
        ("x = " + "[" * 5000, "cannot be read: "),
    ],
)
def test_a_file_without_a_function_is_refused(tmp_path: Path, text: str, what: str) -> None:
    path = tmp_path / "squares.toml"
    path.write_text(text)
    with pytest.raises(StudyError, match=rf"squares\.toml: {what}"):
        load_study(path)


def test_only_a_plain_file_of_some_size_is_read(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    os.mkfifo(tmp_path / "fifo")
    kinds = {
        tmp_path / "fifo": "a pipe",
        Path("/dev/zero"): "a character device",
        tmp_path: "a folder",
    }
    for path, kind in kinds.items():
        with pytest.raises(StudyError, match=f"cannot be read: it is {kind}"):
            load_study(path)
    (tmp_path / "bytes").write_bytes(b"\xff\xfe")
    for name in ("bytes", "missing"):
        with pytest.raises(StudyError, match=f"{name}: cannot be read"):
            load_study(tmp_path / name)
    monkeypatch.setattr(module, "MAX_BYTES", 10)
    (tmp_path / "large").write_text(HEAD)
    with pytest.raises(StudyError, match=f"{len(HEAD)} bytes"):
        load_study(tmp_path / "large")
