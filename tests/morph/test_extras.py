import os
import subprocess
import sys
import tomllib
from importlib.metadata import packages_distributions
from pathlib import Path

import pytest

from morph.extras import EXTRAS, extra_of, install_command

PROJECT = tomllib.loads((Path(__file__).parents[2] / "pyproject.toml").read_text())["project"]

CORE = """
import sys
from morph.extras import EXTRAS

ABSENT = {each for packages in EXTRAS.values() for each in packages}

class Without:
    def __init__(self, finder):
        self.finder = finder

    def __getattr__(self, name):
        return getattr(self.finder, name)

    def find_spec(self, name, path=None, target=None):
        absent = name.partition(".")[0] in ABSENT
        return None if absent else self.finder.find_spec(name, path, target)

sys.meta_path[:] = [Without(each) for each in sys.meta_path if hasattr(each, "find_spec")]
from morph.app.cli.main import main

for line in sys.argv[1:]:
    status = main(line.split())
    if status:
        sys.exit(status)
"""


def distribution(requirement: str) -> str:
    for sign in "[<>=~!; ":
        requirement = requirement.partition(sign)[0]
    return requirement.lower().replace("_", "-")


def without_extras(folder: Path, *lines: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-c", CORE, *lines],
        cwd=folder,
        env={**os.environ, "MORPH_SHELF": str(folder / "none")},
        capture_output=True,
        text=True,
        check=False,
    )


@pytest.mark.parametrize("extra", [*EXTRAS])
def test_every_import_of_an_extra_belongs_to_a_distribution_that_it_requires(extra: str) -> None:
    required = {distribution(each) for each in PROJECT["optional-dependencies"][extra]}
    homes = packages_distributions()
    # An extra that is not installed here has no imports to compare.
    found = {each: {distribution(home) for home in homes.get(each, ())} for each in EXTRAS[extra]}
    # dask comes with distributed.
    found.pop("dask", None)
    assert all(not names or names & required for names in found.values()), found
    assert set().union(*found.values()) >= required or any(not names for names in found.values())


def test_the_core_inspects_converts_simulates_compares_diagnoses_and_excites(
    tmp_path: Path,
) -> None:
    done = without_extras(
        tmp_path,
        "list robots",
        "inspect so101",
        "convert pendulum --to mjcf --out converted",
        "simulate pendulum --seconds 4 --start hinge=1 --out run.csv --quiet",
        "compare pendulum run.csv",
        "diagnose pendulum run.csv --out report --quiet",
        "excite pendulum --for-everything --out plan --quiet",
    )
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "report" / "report.html").is_file()


@pytest.mark.parametrize(
    ("line", "extra", "package"),
    [
        ("learn balance --robot cartpole --out out", "learn", "torch"),
        ("print so101 --printer mk4 --material pla --out out", "print", "manifold3d"),
        ("view pendulum", "view", "viser"),
        ("simulate pendulum --video out.mp4", "view", "imageio_ffmpeg"),
    ],
)
def test_a_command_without_its_extra_names_the_installation_before_it_does_anything(
    tmp_path: Path, line: str, extra: str, package: str
) -> None:
    done = without_extras(tmp_path, line)
    assert done.returncode == 2
    assert package in done.stderr
    assert done.stderr.endswith(f"fix: {install_command(extra)}\n")
    assert "Traceback" not in done.stderr
    assert [*tmp_path.iterdir()] == []


def test_only_packages_of_an_extra_have_one() -> None:
    assert extra_of("torch.nn") == "learn"
    assert extra_of("mujoco") is None
    assert extra_of("torchvision") is None
