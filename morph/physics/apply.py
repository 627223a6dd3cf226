"""Effects written into a description, in an order that theirs does not change."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from morph.physics.effect import Effect


def apply(spec: Any, effects: Iterable[Effect]) -> None:
    """Write into a `mujoco.MjSpec` what MuJoCo can hold of effects.

    Those on contacts come last: a contact is told its stiffness for each kg of effective mass,
    of which rotors, loads and the water around a link are a part. A payload comes after what
    the link itself weighs, which scales the link and not its load.
    """
    for effect in sorted(effects, key=lambda e: (e.kind == "contact", e.name == "payload")):
        effect.edit(spec)
