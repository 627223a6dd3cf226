from __future__ import annotations

import json
import subprocess
import sys
from dataclasses import dataclass, field
from decimal import Decimal
from enum import StrEnum
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from morph.errors import StudyError
from morph.study.cell import Cell, cells_of
from morph.study.encoding import decode_case, decode_row, encode_case, encode_row

WORDS = st.text(max_size=5).filter(lambda text: not text.startswith("!"))
PLAIN = st.recursive(
    st.none()
    | st.booleans()
    | st.integers()
    | st.text()
    | st.floats(allow_nan=False).filter(lambda number: abs(number) != float("inf")),
    lambda inner: (
        st.lists(inner, max_size=3)
        | st.lists(inner, max_size=3).map(tuple)
        | st.dictionaries(WORDS, inner, max_size=3)
    ),
    max_leaves=10,
)


class Colour(StrEnum):
    RED = "red"


@dataclass
class Loose:
    x: int


@dataclass(frozen=True)
class Inner:
    x: float
    names: tuple[str, ...] = ()


@dataclass(frozen=True)
class Outer:
    inner: Inner
    rest: list[Inner] = field(default_factory=list)


@settings(deadline=None, max_examples=50)
@given(st.dictionaries(WORDS, PLAIN, max_size=4))
def test_a_case_comes_back_as_it_was_through_json(case: dict[str, Any]) -> None:
    back = decode_case(json.loads(json.dumps(encode_case(case), allow_nan=False)))
    assert repr(back) == repr(case)


def test_dataclasses_come_back_as_what_they_are(toy: ModuleType) -> None:
    case = {"pairs": [toy.Pair(1, (2, 3)), toy.Pair(4)]}
    assert decode_case(json.loads(json.dumps(encode_case(case)))) == case


def test_a_class_that_is_no_dataclass_is_never_made() -> None:
    with pytest.raises(StudyError, match="not a dataclass"):
        decode_case({"!dataclass": "subprocess:Popen", "fields": {"args": ["true"]}})


def test_rows_keep_numbers_that_are_not_finite_and_forget_their_classes() -> None:
    row = {"inner": Inner(float("inf"), ("a",)), "nan": np.float64("nan")}
    text = json.dumps(encode_row(row), allow_nan=False)
    assert repr(decode_row(json.loads(text))) == (
        "{'inner': {'x': inf, 'names': ['a']}, 'nan': nan}"
    )


@pytest.mark.parametrize(
    ("case", "what"),
    [
        ({"x": float("nan")}, r"case\.x is a float: nan"),
        ({"x": [1, float("inf")]}, r"case\.x\[1\] is a float: inf"),
        ({"x": [2**13_000]}, r"case\.x\[0\] is a int: 13001 bits"),
        ({"x": -(10**5000)}, r"case\.x is a int: 16610 bits"),
        ({"x": object()}, r"case\.x is a object"),
        ({"x": np.int64(1)}, r"case\.x is a int64"),
        ({"x": Decimal(1)}, r"case\.x is a Decimal"),
        ({"x": {1, 2}}, r"case\.x is a set"),
        ({"x": Colour.RED}, r"case\.x is a Colour"),
        ({"x": lambda: 1}, r"case\.x is a function"),
        ({"x": Loose(1)}, r"case\.x is a Loose: .*not frozen"),
        ({1: 2}, "key 1 of case is a int"),
        ({"!x": 2}, "key '!x' of case is a str"),
        ([1], "case is a list: a case is a mapping"),
        (None, "case is a NoneType"),
    ],
)
def test_what_cannot_be_hashed_is_refused_by_its_place(case: Any, what: str) -> None:
    with pytest.raises(StudyError, match=rf"{what}.*\n.*use Python numbers, strings"):
        Cell(function="toy_cells:square", case=case)


def test_a_case_that_holds_itself_is_refused() -> None:
    case: dict[str, Any] = {}
    case["x"] = [case]
    with pytest.raises(StudyError, match="more than 32 values inside each other"):
        Cell(function="toy_cells:square", case=case)


@pytest.mark.parametrize(
    "name", ["square", "toy_cells.square", "toy_cells:", ":f", "a b:c", "a:b.c"]
)
def test_a_name_that_names_no_function_is_refused(name: str) -> None:
    with pytest.raises(StudyError, match="names no function"):
        Cell(function=name, case={})


def test_a_function_that_no_other_process_finds_is_refused() -> None:
    def nested(x: int) -> int:
        return x

    for function in (nested, lambda x: x):
        with pytest.raises(StudyError, match="cannot be found by another process"):
            cells_of(function, [{"x": 1}])


PROGRAM = """
from dataclasses import dataclass
from pathlib import Path
from morph.study.cell import cells_of
from morph.study.run import run

@dataclass(frozen=True)
class Case:
    x: int

def f(case):
    assert type(case) is Case
    return case.x

if __name__ == "__main__":
    (cell,) = cells_of(f, [Case(7)])
    print(cell.function, run([cell], folder=Path("out"))[0].row)
"""


def test_a_program_run_as_a_module_may_hold_its_own_cells(tmp_path: Path) -> None:
    (tmp_path / "program.py").write_text(PROGRAM)
    as_module, as_file = (
        subprocess.run(
            [sys.executable, *how], cwd=tmp_path, capture_output=True, text=True, check=False
        )
        for how in (("-m", "program"), ("program.py",))
    )
    assert as_module.stdout == "program:f 7\n", as_module.stderr
    assert as_file.returncode == 1
    assert "run the program by `python -m MODULE`" in as_file.stderr


def test_equal_cells_have_equal_identities_and_others_do_not(toy: ModuleType) -> None:
    def cell(function: str = "toy_cells:square", **case: Any) -> Cell:
        return Cell(function=function, case=case)

    assert cell(x=1, factor=2).identity == cell(factor=2, x=1).identity
    identities = {
        each.identity
        for each in (
            *(cell(x=1), cell(x=2), cell(x=1.0), cell(x=True), cell(x="1"), cell(x=None)),
            *(cell(x=[1]), cell(x=(1,)), cell(y=1), cell(x=0.0), cell(x=-0.0)),
            *(cell("toy_cells:process", x=1), cell(x={"a": 1}), cell(x=toy.Pair(1))),
        )
    }
    assert len(identities) == 14


def test_the_source_of_a_case_s_class_belongs_to_the_code(
    toy: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    Path("typed_case.py").write_text(
        "from dataclasses import dataclass\n@dataclass(frozen=True)\nclass Case:\n    x: int\n"
    )
    import importlib

    from morph.study import code_hash

    importlib.invalidate_caches()
    case = importlib.import_module("typed_case").Case(1)
    before = Cell(function="toy_cells:square", case=case).code
    with Path("typed_case.py").open("a") as file:
        file.write("    y: int = 2\n")
    code_hash._hash.cache_clear()
    code_hash._closure.cache_clear()
    assert Cell(function="toy_cells:square", case=case).code != before
    sys.modules.pop("typed_case")
