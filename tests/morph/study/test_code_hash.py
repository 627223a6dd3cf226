from __future__ import annotations

import sys
from pathlib import Path

import pytest

import morph
from morph.errors import StudyError
from morph.study import code_hash as module
from morph.study.code_hash import code_hash, sources


@pytest.fixture
def project(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A package of five modules, of which `fast` imports three, each in another way."""
    files = {
        "__init__.py": "",
        "fast.py": "from typing import TYPE_CHECKING\nfrom . import direct\n"
        "if TYPE_CHECKING:\n    from hashed import unused\n"
        "def f():\n    from hashed.inside import g\n    return g\nLATER = 'hashed.named:Class'\n",
        "direct.py": "",
        "inside.py": "def g(): ...\n",
        "named.py": "class Class: ...\n",
        "unused.py": "",
        "kernel.c": "int x;",
    }
    (tmp_path / "hashed").mkdir()
    for name, text in files.items():
        (tmp_path / "hashed" / name).write_text(text)
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.delitem(sys.modules, "hashed", raising=False)
    return tmp_path / "hashed"


def forget() -> None:
    module._hash.cache_clear()
    module._closure.cache_clear()


def test_what_is_imported_at_the_top_inside_a_function_and_by_name_is_covered(
    project: Path,
) -> None:
    names = {path.name for path in sources("hashed.fast")}
    assert names == {"__init__.py", "fast.py", "direct.py", "inside.py", "named.py", "kernel.c"}


def test_a_package_met_above_a_module_first_is_read_whole_where_it_is_imported_later(
    project: Path,
) -> None:
    (project / "__init__.py").write_text("LATER = 'hashed.named:Class'\n")
    (project / "fast.py").write_text("from . import direct, inside\n")
    (project / "direct.py").write_text("import hashed\n")
    assert "named.py" in {path.name for path in sources("hashed.fast")}


@pytest.mark.parametrize("name", ["fast.py", "direct.py", "inside.py", "named.py", "kernel.c"])
def test_a_change_of_any_source_it_runs_changes_the_hash(project: Path, name: str) -> None:
    before = code_hash("hashed.fast")
    with (project / name).open("a") as file:
        file.write("\n")
    forget()
    assert code_hash("hashed.fast") != before


def test_a_change_of_what_it_does_not_import_leaves_the_hash(project: Path) -> None:
    before = code_hash("hashed.fast")
    (project / "unused.py").write_text("x = 1\n")
    forget()
    assert code_hash("hashed.fast") == before


def test_the_package_above_adds_what_it_imports_but_not_what_it_loads_on_request() -> None:
    home = Path(morph.__file__).parent
    paths = set(sources("morph.files"))
    assert {home / "files.py", home / "errors.py"} <= paths
    assert home / "model" / "diagnose.py" not in paths


@pytest.mark.parametrize(
    "call",
    [
        "importlib.import_module('alone_here')",
        "import_module(name='alone_here')",
        "__import__('alone_here')",
    ],
)
def test_a_module_that_is_imported_by_a_call_is_covered(project: Path, call: str) -> None:
    (project.parent / "alone_here.py").write_text("")
    (project / "fast.py").write_text(f"def f():\n    return {call}\n")
    assert project.parent / "alone_here.py" in sources("hashed.fast")


def test_a_module_that_is_imported_by_a_relative_call_is_covered(project: Path) -> None:
    (project / "fast.py").write_text("def f():\n    return import_module('.unused', __package__)\n")
    assert project / "unused.py" in sources("hashed.fast")


@pytest.mark.parametrize(
    "text",
    [
        "from importlib import import_module as im\nim('alone_here')\n",
        "import importlib\nload = importlib.import_module\nload('alone_here')\n",
        "import importlib\ngetattr(importlib, 'import_module')('alone_here')\n",
        "from importlib import *\nfor each in ['alone_here']:\n    import_module(each)\n",
        "import builtins as b\nb.__import__('alone' '_here')\n",
        "from pkgutil import resolve_name as r\nr('alone_here:f')\n",
    ],
)
def test_a_module_that_is_named_where_modules_are_loaded_by_name_is_covered(
    project: Path, text: str
) -> None:
    (project.parent / "alone_here.py").write_text("")
    (project / "fast.py").write_text(text)
    assert project.parent / "alone_here.py" in sources("hashed.fast")


def test_a_word_that_is_also_a_module_counts_only_where_modules_are_loaded_by_name(
    project: Path,
) -> None:
    (project.parent / "alone_here.py").write_text("")
    (project / "fast.py").write_text("import importlib.metadata\nx = 'alone_here', '.'\n")
    assert project.parent / "alone_here.py" not in sources("hashed.fast")


@pytest.mark.parametrize(
    ("test", "covered"),
    [
        ("TYPE_CHECKING", False),
        ("typing.TYPE_CHECKING", False),
        ("not TYPE_CHECKING", True),
        ("FAST or TYPE_CHECKING", True),
        ("settings.TYPE_CHECKING", True),
    ],
)
def test_only_what_is_for_type_checkers_alone_is_left_out(
    project: Path, test: str, covered: bool
) -> None:
    (project / "fast.py").write_text(
        f"if {test}:\n    import hashed.unused\nelse:\n    import hashed.inside\n"
    )
    files = sources("hashed.fast")
    assert (project / "unused.py" in files, project / "inside.py" in files) == (covered, True)


@pytest.mark.parametrize("text", [b'print "x"\n', b"x = 1\0\n", b"\xff\n"])
def test_a_file_that_this_python_cannot_read_is_hashed_and_not_followed(
    project: Path, text: bytes
) -> None:
    (project / "fast.py").write_text("try:\n    import hashed.old\nexcept SyntaxError: ...\n")
    (project / "old.py").write_bytes(text)
    before = code_hash("hashed.fast")
    (project / "old.py").write_bytes(text + b"#")
    forget()
    assert code_hash("hashed.fast") != before


def test_a_change_in_any_folder_that_is_imported_from_changes_the_hash(
    project: Path, tmp_path_factory: pytest.TempPathFactory
) -> None:
    other = tmp_path_factory.mktemp("current")
    (project / "fast.py").write_text("import beside_current\n")
    (other / "beside_current.py").write_text("x = 1\n")
    before = code_hash("hashed.fast", path=[other])
    (other / "beside_current.py").write_text("x = 2\n")
    forget()
    assert code_hash("hashed.fast", path=[other]) != before
    assert code_hash("hashed.fast") == code_hash("hashed.fast", path=[project])


def test_what_runs_the_cells_is_no_part_of_their_code(project: Path) -> None:
    (project / "fast.py").write_text(
        "from hashed import direct\nfrom hashed.engine.run import f\nimport hashed.engine_two\n"
    )
    (project / "engine").mkdir()
    (project / "engine" / "__init__.py").write_text("")
    (project / "engine" / "run.py").write_text("import hashed.inside\n")
    (project / "engine_two.py").write_text("")
    names = {path.name for path in sources("hashed.fast", ignore=("hashed.engine",))}
    # Neither it, nor what it alone imports; `engine_two` only begins with the same letters.
    assert names == {"__init__.py", "fast.py", "direct.py", "engine_two.py", "kernel.c"}
    before = code_hash("hashed.fast", ignore=("hashed.engine",))
    (project / "engine" / "run.py").write_text("import hashed.inside\nx = 1\n")
    forget()
    assert code_hash("hashed.fast", ignore=("hashed.engine",)) == before
    # Asked for itself, it is followed.
    assert project / "inside.py" in sources("hashed.engine.run", ignore=("hashed.engine",))


def test_a_study_does_not_depend_on_the_engine_unless_it_measures_it() -> None:
    engine = Path(morph.__file__).parent / "study" / "run.py"
    assert engine not in sources("experiments.engine_options")
    assert engine in sources("experiments.engine_options", ignore=())
    assert engine.with_name("store.py") in sources("morph.study.run")


def test_a_module_that_is_not_there_is_refused_by_name() -> None:
    with pytest.raises(StudyError, match=r"no module 'nowhere\.at_all'"):
        code_hash("nowhere.at_all")
    with pytest.raises(StudyError, match=r"'morph\.nothing' has no source"):
        code_hash("morph.nothing")
