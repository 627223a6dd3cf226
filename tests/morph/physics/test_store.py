"""Effects read from files: what is no effect is refused, in three parts."""

from __future__ import annotations

from pathlib import Path

import pytest

from morph.errors import EffectError
from morph.physics.store import effect_of, load_effects

HEAD = 'schema = "morph.effects/1"\n[[effect]]\n'


@pytest.mark.parametrize(
    ("text", "what"),
    [
        ("schema = ", "cannot be read"),
        ("", "no schema"),
        ('schema = "morph.effects/9"', "no schema"),
        ('schema = "morph.effects/1"\neffect = 3', "no schema"),
        (HEAD + 'name = "viscous_friction"', "needs a name and a where"),
        (HEAD + 'where = "hinge"', "needs a name and a where"),
        (HEAD + 'name = "stiction"\nwhere = "hinge"', "there is no effect 'stiction'"),
        (HEAD + 'name = "viscous_friction"\nwhere = "hinge"\nc = 0.1', "c = 0.1 is not .* of b"),
        (HEAD + 'name = "viscous_friction"\nwhere = "hinge"\nb = "0.1"', "b = '0.1' is not"),
        (HEAD + 'name = "viscous_friction"\nwhere = "hinge"\nb = true', "b = True is not"),
        (HEAD + 'name = "viscous_friction"\nwhere = "hinge"\nb = [0.1]', "is not a number"),
        (HEAD + 'name = "viscous_friction"\nwhere = "hinge"\nb = nan', "b = nan .* 0 to 10000"),
        (HEAD + 'name = "viscous_friction"\nwhere = "hinge"\nb = -1', "b = -1 .* 0 to 10000"),
        pytest.param(
            HEAD + f'name = "viscous_friction"\nwhere = "hinge"\nb = 1{"0" * 400}',
            "b = ",
        ),
        pytest.param(
            HEAD + f'name = "viscous_friction"\nwhere = "hinge"\nb = 1{"0" * 5000}',
            "cannot be read",
        ),
    ],
)
def test_a_file_of_effects_that_cannot_be_used_is_refused(
    tmp_path: Path, text: str, what: str
) -> None:
    path = tmp_path / "corrected.toml"
    path.write_text(text)
    with pytest.raises(EffectError, match=what) as caught:
        load_effects(path)
    assert caught.value.where
    assert caught.value.fix


@pytest.mark.parametrize("content", [None, b"\xff\xfe", b"\0"])
def test_a_file_that_is_missing_or_no_text_is_refused(
    tmp_path: Path, content: bytes | None
) -> None:
    path = tmp_path / "corrected.toml"
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(EffectError, match="cannot be read") as caught:
        load_effects(path)
    assert caught.value.where == str(path)
    assert "corrected.toml" in caught.value.fix


@pytest.mark.parametrize("table", [3, "viscous_friction", [], {"name": "viscous_friction"}])
def test_what_is_no_table_of_an_effect_is_refused(table: object) -> None:
    with pytest.raises(EffectError, match="needs a name and a where") as caught:
        effect_of(table, where="corrected.toml, effect 2")
    assert caught.value.where == "corrected.toml, effect 2"
    assert "name" in caught.value.fix
