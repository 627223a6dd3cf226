"""What the first import and the first command may load."""

import subprocess
import sys

import pytest

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


PUBLIC = {"Channel", "EFFECTS", "Recording", "Simulator", "__version__", "diagnose", "load"} | {
    "load_policy",
    "load_recordings",
    "record",
    "simulate",
    "world",
}


@pytest.mark.parametrize("name", sorted(PUBLIC))
def test_every_public_name_is_there_when_asked_for(name: str) -> None:
    import morph

    assert name in dir(morph)
    assert getattr(morph, name)


def test_the_public_names_are_these_and_no_others() -> None:
    import morph

    assert set(morph.__all__) == PUBLIC


def test_recordings_are_read_by_the_name_record_too() -> None:
    loaded_by("import morph\nassert morph.record.load is morph.load_recordings")


def test_a_name_that_morph_lacks_is_an_attribute_error() -> None:
    import morph

    with pytest.raises(AttributeError, match="module 'morph' has no attribute 'lode'"):
        morph.lode  # type: ignore[attr-defined]  # noqa: B018
