"""Cards: what is read, and what is refused with its line."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from morph.body.card import load_card
from morph.errors import RobotError

# Seven lines; what a test adds starts on the eighth.
HEAD = """schema = "morph.card/1"
name = "fish"
title = "Fish"
description = "robot.xml"
base = "floating"
source = [ { what = "length", from = "a ruler" } ]
licence = "Apache-2.0"
"""

FULL = """tasks = ["swim"]
checks = { mass_kg = 17, dof = 7 }

[water]
mass_kg = 17.0
displaced_volume_m3 = 0.017
scale = 1.0
wetted = "box"

[[motor]]
actuator = "tail"

[[closure]]
kind = "four-bar"
bodies = ["thigh", "crank", "rod"]

[[parameter]]
name = "tail_length"
operation = "scale"
link = "tail"
low = 0.5
high = 2.0

[print]
printed = ["tail"]
bought = [ { part = "STS3215", count = 1, mass_kg = 0.055, link = "tail" } ]
"""


def written(folder: Path, text: str) -> Path:
    """Return a card's path in a folder that bears its name."""
    path = folder / "fish" / "card.toml"
    path.parent.mkdir()
    path.write_text(text)
    return path


def test_every_key_of_a_full_card_is_read(tmp_path: Path) -> None:
    card = load_card(written(tmp_path, HEAD + FULL))
    assert card.source[0].from_ == "a ruler"
    assert card.checks.mass_kg == 17.0
    assert card.water is not None
    assert card.water.wetted == "box"
    assert card.motor[0].model == "ideal"
    assert card.closure[0].bodies == ("thigh", "crank", "rod")
    assert card.parameter[0].high == 2.0
    assert card.print is not None
    assert card.print.bought[0].mass_kg == 0.055


@pytest.mark.parametrize(
    ("text", "line", "message"),
    [
        (HEAD + "licences = 1\n", 8, "'licences' is unknown; the nearest known one is 'licence'"),
        (HEAD + FULL.replace("scale = 1.0", "skale = 1"), 14, "nearest known one is 'scale'"),
        (HEAD + FULL.replace("[water]", "[watter]"), 11, "nearest known one is 'water'"),
        (HEAD + FULL + '[[motor]]\nmodell = "x"\n', 35, "nearest known one is 'model'"),
        (HEAD + '[[motor]]\nmodel = "x"\n', 8, "the key 'actuator' is missing"),
        (HEAD.replace('title = "Fish"\n', ""), 1, "the key 'title' is missing"),
        (HEAD.replace('"Fish"', "3"), 3, "title is 3, of type int, not str"),
        (HEAD + "tasks = 3\n", 8, "tasks is 3, of type int, not list"),
        (HEAD + "checks = 3\n", 8, "checks is 3, not a table"),
        (HEAD + "checks = { dof = 1.5 }\n", 8, "dof is 1.5, of type float, not int"),
        (HEAD.replace("card/1", "card/2"), 1, "schema is 'morph.card/2', not 'morph.card/1'"),
        (HEAD.replace("floating", "flying"), 5, "base is 'flying', not 'fixed' or 'floating'"),
        (HEAD.replace('"fish"', '"bird"'), 2, "name is 'bird', not 'fish'"),
        (HEAD + FULL.replace('"box"', '"skin"'), 15, "wetted is 'skin', not 'mesh' or 'hull'"),
    ],
)
def test_a_mistake_is_refused_with_its_line(
    tmp_path: Path, text: str, line: int, message: str
) -> None:
    with pytest.raises(RobotError, match=message) as caught:
        load_card(written(tmp_path, text))
    assert caught.value.where.endswith(f"card.toml:{line}")


@pytest.mark.parametrize("content", [b"name = ", b"\x80"])
def test_what_is_not_toml_is_refused(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "card.toml"
    path.write_bytes(content)
    with pytest.raises(RobotError, match="is not TOML"):
        load_card(path)


def refused(folder: Path, text: str) -> RobotError:
    path = written(folder, text)
    with pytest.raises(RobotError) as caught:
        load_card(path)
    assert caught.value.fix
    return caught.value


@pytest.mark.parametrize("description", ["../canary.xml", "/canary.xml", "link.xml", "a\\u0000"])
def test_a_description_outside_the_cards_folder_is_refused_with_its_line(
    description: str, tmp_path: Path
) -> None:
    (tmp_path / "canary.xml").write_text("<mujoco/>")
    path = written(tmp_path, HEAD.replace("robot.xml", description))
    (path.parent / "link.xml").symlink_to(tmp_path / "canary.xml")
    with pytest.raises(RobotError, match="is no file in the card's folder") as caught:
        load_card(path)
    assert caught.value.where == f"{path}:4"


def test_a_description_below_the_cards_folder_and_a_link_within_it_are_read(tmp_path: Path) -> None:
    path = written(tmp_path, HEAD.replace("robot.xml", "link.xml"))
    (path.parent / "link.xml").symlink_to("mjcf/robot.xml")
    assert load_card(path).description == "link.xml"


def test_a_card_that_fits_no_memory_is_refused(tmp_path: Path) -> None:
    path = written(tmp_path, HEAD)
    # Sparse: 1 TiB of zeros.
    os.truncate(path, 2**40)
    with pytest.raises(RobotError, match="262144 are read at most"):
        load_card(path)


def test_a_card_that_is_a_pipe_is_not_waited_for(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "card.toml")
    with pytest.raises(RobotError, match="it is a pipe, no regular file"):
        load_card(tmp_path / "card.toml")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("x = " + "[\n" * 2000 + "]\n" * 2000, "nests too deeply"),
        (
            f"tasks = [ {{ {'.'.join('x' * 1500)} = 1 }} ]\n",
            "1499 dots, of which 1000 may be (at line",
        ),
        (f"{'.'.join('x' * 50_000)} = 1\n", "49999 dots, of which 1000 may be (at line"),
    ],
)
def test_a_card_that_nests_without_end_is_refused(text: str, message: str, tmp_path: Path) -> None:
    assert message in refused(tmp_path, HEAD + text).what


@pytest.mark.parametrize("mass", ["nan", "inf", "0", "-1.0"])
@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("checks = {{ mass_kg = {} }}", 8),
        ('[[measured]]\nlink = "fin"\nmass_kg = {}', 10),
    ],
)
def test_a_mass_that_no_scale_shows_is_refused_with_its_line(
    text: str, line: int, mass: str, tmp_path: Path
) -> None:
    error = refused(tmp_path, HEAD + text.format(mass))
    assert error.what.endswith(f"weighs {float(mass):g} kg")
    assert error.where.endswith(f"card.toml:{line}")


def test_a_link_that_is_weighed_twice_is_refused_with_its_line(tmp_path: Path) -> None:
    table = '[[measured]]\nlink = "fin"\nmass_kg = 1\n'
    error = refused(tmp_path, HEAD + table + table)
    assert error.what == "its card weighs the link 'fin' twice"
    assert error.where.endswith("card.toml:12")
