"""The wheel works where the repository is not."""

import os
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    # A copy, so that building leaves nothing here and takes up no stale build folder.
    copy = tmp_path_factory.mktemp("copy")
    unwanted = shutil.ignore_patterns("__pycache__")
    for folder in ("align", "experiments", "morph", "print", "robots", "tests"):
        shutil.copytree(ROOT / folder, copy / folder, symlinks=True, ignore=unwanted)
    for file in ("LICENSE", "NOTICE", "README.md", "pyproject.toml"):
        shutil.copy(ROOT / file, copy)
    run([sys.executable, "-m", "build", "--wheel", "--no-isolation", "--outdir", "dist"], copy)
    (built,) = (copy / "dist").glob("*.whl")
    return built


@pytest.fixture(scope="module")
def site(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    target = tmp_path_factory.mktemp("site")
    pip = [sys.executable, "-m", "pip", "install", "--disable-pip-version-check"]
    run([*pip, "--no-deps", "--no-index", "--target", str(target), str(wheel)], target)
    return target


def run(command: list[str], folder: Path, **variables: str) -> str:
    done = subprocess.run(
        command,
        cwd=folder,
        env={**os.environ, **variables},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def installed(site: Path, away: Path, *command: str) -> str:
    # The path comes before an editable installation's, and the home and the user's shelf are empty.
    return run(
        list(command), away, PYTHONPATH=str(site), HOME=str(away), MORPH_SHELF=str(away / "none")
    )


def test_the_wheel_holds_the_packages_and_the_shelf_and_nothing_else(wheel: Path) -> None:
    names = {Path(name) for name in zipfile.ZipFile(wheel).namelist()}
    tops = {name.parts[0] for name in names}
    assert tops == {"morph", "morph_robotics-0.1.0.dist-info"}
    for package in ("morph", "morph/alignment", "morph/print"):
        assert Path(package, "py.typed") in names


def test_the_wheel_holds_every_file_of_the_shelf(wheel: Path) -> None:
    names = set(zipfile.ZipFile(wheel).namelist())
    shelf = {
        f"morph/{path.relative_to(ROOT).as_posix()}"
        for path in (ROOT / "robots").rglob("*")
        if path.is_file()
    }
    assert shelf
    assert shelf <= names


def test_the_wheel_holds_every_schema(wheel: Path) -> None:
    names = set(zipfile.ZipFile(wheel).namelist())
    schemas = {path.relative_to(ROOT).as_posix() for path in ROOT.glob("morph/**/*.schema.json")}
    assert {Path(name).name.partition(".")[0] for name in schemas} == {
        *("align", "comparison", "conversion", "diagnosis", "experiment", "findings", "inspection"),
        *("learned", "package"),
        *("simulation", "transfer", "view", "viewing"),
    }
    assert schemas <= names


def test_the_installed_morph_finds_its_shelf(site: Path, tmp_path: Path) -> None:
    code = (
        "import morph, morph.body.shelf as s; print(morph.__file__, morph.__version__, *s.names())"
    )
    file, version, *robots = installed(site, tmp_path, sys.executable, "-c", code).split()
    assert Path(file).is_relative_to(site)
    assert version == "0.1.0"
    assert robots == sorted(card.parent.name for card in ROOT.glob("robots/*/card.toml"))


def test_the_installed_morph_loads_a_robot(site: Path, tmp_path: Path) -> None:
    code = "import morph; print(morph.load('pendulum').name)"
    assert installed(site, tmp_path, sys.executable, "-c", code).strip() == "pendulum"


def test_the_installed_command_lists_the_robots(site: Path, tmp_path: Path) -> None:
    assert "cartpole" in installed(site, tmp_path, str(site / "bin" / "morph"), "list", "robots")
