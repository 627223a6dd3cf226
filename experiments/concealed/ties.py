"""Effects that no recording of a case can tell from the one left out, with the reason."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from experiments.concealed.mechanism import TORQUE
from experiments.concealed.truth import Effect, Truth


@dataclass(frozen=True, kw_only=True)
class Tie:
    """Another answer that fits as well."""

    effect: str
    """Name of the law."""
    where: str
    """Name of the part."""
    reason: str
    """Why no refit of this case can tell them apart."""


def ties_of(truth: Truth, effect: Effect) -> tuple[Tie, ...]:
    """Return the other answers that are as right as the effect itself.

    Only exact equalities count: the same equations of motion for some figures of the other law,
    with the description's own parameters inside what `vary` allows.
    """
    m, i, name = truth.mechanism, effect.place, effect.law.name
    joint, link, actuator = m.joints[i], m.links[i], m.actuator(i)
    kind = m.plant.of_joint("drive")[i]
    hinge = not m.plant.slide[i]
    found: list[Tie] = []

    def add(law: str, where: str, reason: str) -> None:
        found.append(Tie(effect=law, where=where, reason=reason))

    if kind and not _coasted(truth) and name in ("viscous_friction", "back_emf"):
        other, where = (
            ("back_emf", actuator) if name == "viscous_friction" else ("viscous_friction", joint)
        )
        add(other, where, "the drive is never cut off, and back-EMF is viscous while it is powered")
    if i == 0 and effect.law.kind != "world":
        first = {
            "viscous_friction": ("linear_drag", link),
            "linear_drag": ("viscous_friction", joint),
            "quadratic_damping": ("quadratic_drag", link),
            "quadratic_drag": ("quadratic_damping", joint),
        }
        if name in first:
            add(*first[name], "the first link moves with its joint alone, in one way")
        heavier = {"armature": joint, "added_mass": link, "link_inertia": link}
        if _is_weightless(truth):
            heavier["payload"] = link
        grows = name != "link_inertia" or effect.figures.get("mass", 1.0) > 1.0
        if name in ("armature", "added_mass") or (name in heavier and "payload" in heavier):
            for law, where in heavier.items():
                if law != name and grows:
                    add(law, where, "of the first link only the inertia along its joint counts")
        if name == "sensor_bias" and kind == TORQUE and hinge:
            add("base_tilt", "world", "turning the first hinge's zero turns gravity for all links")
        if name == "sensor_bias" and m.plant.count == 1:
            add("com_offset", link, "an angle of the only hinge is a side step of the centre")
    if m.plant.count == 1:
        if name in ("base_tilt", "com_offset"):
            for law, where in (("sensor_bias", f"{joint}.position"), ("base_tilt", "world"),
                               ("com_offset", link)):  # fmt: skip
                if law != name:
                    add(law, where, "all three turn the rest position of the only hinge")
        if name == "actuator_delay" and kind == TORQUE:
            add("timestamp_offset", f"{joint}.position", "the only sensor and the only drive")
        if name == "timestamp_offset" and kind == TORQUE:
            add("actuator_delay", actuator, "the only sensor and the only drive")
        bare = m.plant.of_joint("rotor")[0] == 0 and m.plant.of_joint("viscous")[0] == 0
        if name == "torque_scale" and bare:
            add("link_inertia", link, "with torques g times as large the link seems 1/g as heavy")
        if name == "link_inertia" and bare:
            add("torque_scale", actuator, "a link g times as heavy seems driven 1/g as much")
    return tuple(found)


def _is_weightless(truth: Truth) -> bool:
    """Return whether gravity never moves the first joint: a level slide or an upright hinge."""
    plant = truth.mechanism.plant
    upright = abs(float((plant.rotation[0] @ plant.axis[0])[2]))
    tilted = any(effect.law.name == "base_tilt" for effect in truth.effects)
    return not tilted and (upright < 1e-6 if plant.slide[0] else upright > 1 - 1e-6)


def are_distinct(truth: Truth) -> bool:
    """Return whether no two effects share an answer, so that their set can be found at all."""
    seen: set[tuple[str, str]] = set()
    for effect in truth.effects:
        answers = {(effect.law.name, effect.where(truth.mechanism))}
        answers |= {(tie.effect, tie.where) for tie in ties_of(truth, effect)}
        if answers & seen:
            return False
        seen |= answers
    return True


def _coasted(truth: Truth) -> bool:
    """Return whether drives are cut off in motion anywhere in the training runs.

    A servo that rests at exactly 0 is not powered either, but nothing moves then.
    """
    return any(bool(np.isnan(run.reference).any()) for run in truth.runs[:-1])
