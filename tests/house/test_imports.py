"""What the first import and the first command may load."""

import ast
import importlib
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
HEAVY = {"torch", "sklearn", "trimesh", "viser", "pinocchio"}

HELP = """
import sys
sys.argv = ["morph", "--help"]
from morph.app.cli import main
try:
    main()
except SystemExit as stop:
    assert not stop.code, stop.code
"""


def loaded_by(code: str) -> set[str]:
    report = "\nimport sys\nprint('loaded:', *sys.modules)"
    run = subprocess.run(
        [sys.executable, "-c", code + report], capture_output=True, text=True, check=False
    )
    assert run.returncode == 0, run.stderr
    return set(run.stdout.rpartition("loaded:")[2].split())


def test_import_morph_loads_no_engine_and_nothing_heavy() -> None:
    assert loaded_by("import morph") & (HEAVY | {"mujoco", "numpy", "scipy"}) == set()


def test_help_loads_nothing_heavy() -> None:
    assert loaded_by(HELP) & HEAVY == set()


PUBLIC = {
    *("Channel", "EFFECTS", "Recording", "Simulator", "__version__", "compare", "diagnose"),
    *("load", "load_policy", "load_recordings", "simulate", "world"),
    *("align", "learn", "loop", "print_package", "transfer", "view"),
}
STUBS = sorted({*ROOT.glob("morph/**/__init__.pyi"), *ROOT.glob("align/__init__.pyi")})
DEEP = re.compile(r"^\s*(from morph\.\w+\.[\w.]+ import .*)$", re.MULTILINE)
"""An import from more than two levels down."""


@pytest.mark.parametrize("name", sorted(PUBLIC))
def test_every_public_name_is_there_when_asked_for(name: str) -> None:
    import morph

    assert name in dir(morph)
    assert getattr(morph, name)


def test_the_public_names_are_these_and_no_others() -> None:
    import morph

    assert set(morph.__all__) == PUBLIC


@pytest.mark.parametrize("stub", STUBS, ids=lambda stub: str(stub.relative_to(ROOT)))
def test_every_name_of_a_stub_is_there_also_where_a_module_has_that_name(stub: Path) -> None:
    parts = stub.parent.relative_to(ROOT).parts
    package = ".".join(parts if parts != ("align",) else ("morph", "alignment"))
    names = [
        (f"{package}.{node.module}", each.name)
        for node in ast.parse(stub.read_text()).body
        if isinstance(node, ast.ImportFrom)
        for each in node.names
    ]
    assert names
    for module, name in names:
        # The module first: its import must not hide the name of the package.
        wanted = getattr(importlib.import_module(module), name)
        assert getattr(importlib.import_module(package), name) is wanted


def test_the_documentation_imports_from_two_levels_but_for_twenty_lines() -> None:
    pages = [ROOT / "README.md", *ROOT.glob("docs/**/*.md")]
    lines = {line for page in pages for line in DEEP.findall(page.read_text(encoding="utf-8"))}
    assert len(lines) <= 20, sorted(lines)


def test_a_name_that_morph_lacks_is_an_attribute_error() -> None:
    import morph

    with pytest.raises(AttributeError, match="No morph attribute lode"):
        morph.lode  # type: ignore[attr-defined]  # noqa: B018
