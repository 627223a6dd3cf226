"""Names of parts."""

from __future__ import annotations

import pytest

from morph.fabrication.names import UniqueNames, of_file, safe, shared, sided


@pytest.mark.parametrize(
    ("text", "name"),
    [
        ("four AAA cells in a holder", "four_aaa_cells_in_a_holder"),
        ("../../etc/passwd", "etc_passwd"),
        ("MX-28", "mx_28"),
        ("Öl & Café", "l_caf"),
        ("***", "part"),
        ("a" * 300, "a" * 60),
    ],
)
def test_any_text_becomes_a_name_that_can_name_a_file(text: str, name: str) -> None:
    assert safe(text) == name


def test_copies_are_called_by_what_their_links_share_without_the_side() -> None:
    assert shared(["front_left_upper_leg", "rear_right_upper_leg"]) == "upper_leg"
    assert shared(["left", "right"]) == "left"
    assert shared(["pole_1"]) == "pole_1"


def test_the_number_that_an_importer_gave_a_file_is_no_part_of_its_name() -> None:
    assert of_file("12_Left-Sheet.STL") == "left_sheet"


def test_a_name_is_given_once() -> None:
    names = UniqueNames()
    assert [names.one("leg"), names.one("leg"), names.one("leg")] == ["leg", "leg_2", "leg_3"]


def test_names_that_do_not_agree_tell_no_side() -> None:
    assert sided(["left_arm", "l_hand"]) == "left"
    assert sided(["left_arm", "right_arm"]) == ""
    assert sided(["arm"]) == ""
