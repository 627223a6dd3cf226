"""Every effect is listed, sourced and documented, under a name of the vocabulary."""

import importlib
import inspect
import re
from pathlib import Path

import pytest

from morph.physics import EFFECTS
from morph.physics.effect import Effect

ROOT = Path(__file__).parents[2]
PHYSICS = ROOT / "morph" / "physics"

_NAMES = """
    viscous_friction coulomb_friction stribeck_friction load_dependent_friction
    position_dependent_friction quadratic_damping joint_stiffness cogging hysteresis backlash
    series_elasticity end_stop actuator_delay actuator_lag torque_scale torque_saturation
    speed_torque_limit back_emf thermal_derating voltage_sag dead_zone sensor_bias
    sensor_scale timestamp_offset payload com_offset link_inertia armature base_tilt
    linear_drag quadratic_drag added_mass buoyancy fluid_current thrust contact_friction
    contact_softness restitution ground_slope external_push tether ground
"""
VOCABULARY = frozenset(_NAMES.split())
"""The names of left-out physics, used in code, on the command line and in every output."""

FOLDERS = {"fluid": {"body", "world"}}
"""Folders that hold more than the one kind that they are named for."""


def effects_in(file: Path) -> list[type[Effect]]:
    module = importlib.import_module(".".join(file.relative_to(ROOT).with_suffix("").parts))
    return [
        thing
        for thing in vars(module).values()
        if inspect.isclass(thing)
        and issubclass(thing, Effect)
        and not inspect.isabstract(thing)
        and thing.__module__ == module.__name__
    ]


FILES = sorted(file for file in PHYSICS.glob("*/*.py") if file.stem in VOCABULARY)


def test_every_effect_stands_in_a_file_named_as_it_is() -> None:
    # Other files of these folders hold what effects share.
    assert {effect.name for effect in EFFECTS} == {file.stem for file in FILES}


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.stem)
def test_a_file_holds_one_effect_named_as_the_file_and_listed(file: Path) -> None:
    (effect,) = effects_in(file)
    assert effect in EFFECTS
    assert effect.name == file.stem
    assert effect.kind in FOLDERS.get(file.parent.name, {file.parent.name})


def test_no_effect_is_listed_twice() -> None:
    assert len({effect.name for effect in EFFECTS}) == len(EFFECTS) == len(FILES)


@pytest.mark.parametrize("effect", EFFECTS, ids=lambda effect: effect.name)
def test_an_effect_names_its_source(effect: type[Effect]) -> None:
    assert re.search(r"^Source: \S", inspect.getdoc(effect) or "", re.MULTILINE)


@pytest.mark.parametrize("effect", EFFECTS, ids=lambda effect: effect.name)
def test_an_effect_and_its_twins_are_in_the_vocabulary(effect: type[Effect]) -> None:
    assert effect.name in VOCABULARY
    assert effect.twins
    assert {*effect.twins, *effect.separate_by} <= VOCABULARY - {effect.name}


@pytest.mark.parametrize("effect", EFFECTS, ids=lambda effect: effect.name)
def test_an_effect_says_what_a_recording_must_hold_to_show_it(effect: type[Effect]) -> None:
    assert effect.excited_by.endswith(".")


@pytest.mark.parametrize("effect", EFFECTS, ids=lambda effect: effect.name)
def test_an_effect_and_its_parameters_are_in_the_list_for_users(effect: type[Effect]) -> None:
    text = (ROOT / "docs" / "effects.md").read_text(encoding="utf-8")
    (row,) = [line for line in text.splitlines() if line.startswith(f"| `{effect.name}` |")]
    for parameter in effect.parameters():
        assert f"{parameter.name}: {parameter.unit}" in row
    for twin in effect.twins:
        assert twin in row
