"""The recipe for conda asks for what the wheel asks for."""

import tomllib
from pathlib import Path

import yaml
from packaging.requirements import Requirement

ROOT = Path(__file__).parents[2]
NAMES = {"mujoco": "mujoco-python"}
"""Packages that conda-forge calls otherwise."""
OURS = {"python", "c-compiler"}
"""What pip leaves to the machine."""


def test_the_recipe_has_the_dependencies_the_version_and_the_command_of_the_project() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    recipe = yaml.safe_load((ROOT / "conda" / "recipe.yaml").read_text())
    wheel = {
        (NAMES.get(each.name, each.name), str(each.specifier))
        for each in map(Requirement, project["dependencies"])
    }
    listed = [
        (each.name, str(each.specifier)) for each in map(Requirement, recipe["requirements"]["run"])
    ]
    assert {each for each in listed if each[0] not in OURS} == wheel
    assert dict(listed)["python"] == project["requires-python"]
    assert recipe["context"]["version"] == project["version"]
    assert recipe["package"]["name"] == project["name"]
    ((name, entry),) = project["scripts"].items()
    assert recipe["build"]["python"]["entry_points"] == [f"{name} = {entry}"]
