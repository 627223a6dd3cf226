"""Figures of a description that may be wrong: masses, centres of mass, inertias and gains."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np

from morph.body.robot import Robot
from morph.body.spec import spec_of
from morph.body.vary.scale import Scale
from morph.errors import DiagnosisError

TRUST: Mapping[str, float] = {
    "mass": 0.10,
    "com": 0.10,
    "inertia": 0.10,
    "gain": 0.05,
    "joint": 0.10,
}
"""The fraction by which each kind of figure may be wrong when nothing is said."""


LEAST_OF_JOINT, SPREAD_OF_JOINT = 0.05, 0.5
"""Least factor on a joint's damping, armature, dry friction and stiffness, and standard deviation
of its logarithm beforehand: descriptions state them to keep a simulation stable, far too great at
times. What is too small an effect adds to."""


@dataclass(frozen=True, kw_only=True)
class Knob:
    """One figure of the description, as the logarithm of a factor on it."""

    kind: str
    """mass, com, inertia, weight, length (of a link), gain (of an actuator), joint (damping and the
    like), world (gravity)."""
    part: str
    """The link, actuator or joint; `world` for gravity."""
    what: str
    """The figure: mass, com, inertia, gain, rate_gain, damping, armature and the like; weight is
    mass and inertia together, length the size of a link whose mass stays."""
    fraction: float
    """By how much it may be wrong."""
    guessed: bool = False
    """Whether it is a joint's, of which `--vary` says nothing."""
    freed: bool = False
    """Whether it may be far less than that fraction allows."""

    @property
    def name(self) -> str:
        """Its name in reports, as `mass:pole`."""
        return f"{self.what}:{self.part}"

    @property
    def bounds(self) -> tuple[float, float]:
        """The least and greatest logarithm of the factor."""
        f = self.fraction
        if self.freed:
            return math.log(LEAST_OF_JOINT), math.log1p(f)
        # Half and twice, and no less for more, then one over it.
        return min(math.log1p(-min(f, 0.5)), -math.log1p(f)), math.log1p(f)

    @property
    def spread(self) -> float:
        """Standard deviation of the logarithm of the factor before any data."""
        return SPREAD_OF_JOINT if self.freed else self.fraction

    def edit(self, spec: Any, logarithm: float) -> None:
        """Multiply the figure in a `mujoco.MjSpec`."""
        factor = math.exp(logarithm)
        if self.kind == "gain":
            actuator = spec.actuator(self.part)
            if self.what == "rate_gain":
                bias = actuator.biasprm.copy()
                bias[2] *= factor
                actuator.biasprm = bias
            else:
                scale = np.ones_like(actuator.biasprm)
                scale[:2] = factor
                actuator.biasprm = actuator.biasprm * scale
                actuator.gainprm = actuator.gainprm * factor
        elif self.kind == "joint":
            joint = spec.joint(self.part)
            setattr(joint, self.what, getattr(joint, self.what) * factor)
        elif self.kind == "world":
            spec.option.gravity = np.asarray(spec.option.gravity) * factor
        elif self.kind == "length":
            Scale(link=self.part, factor=factor, mass="keep").apply(spec)
        else:
            body = spec.body(self.part)
            if self.what == "com":
                body.ipos = body.ipos * factor
            elif self.what == "mass":
                body.mass *= factor
            elif self.what == "weight":
                body.mass *= factor
                body.inertia = body.inertia * factor
                body.fullinertia = body.fullinertia * factor
            else:
                body.inertia = body.inertia * factor
                body.fullinertia = body.fullinertia * factor


def knobs(robot: Robot, vary: Mapping[str, float] | None = None) -> tuple[Knob, ...]:
    """Return every figure of a robot that matters to its motion and may be wrong.

    Args:
        robot: The nominal description.
        vary: Fraction by which a kind (`mass`), a figure of a part (`mass:pole`) or a
            part's every figure (`pole`) may be wrong; zero trusts it fully.

    Raises:
        DiagnosisError: A name in `vary` fits nothing, or a fraction is not in [0, 50].
    """
    vary = dict(vary or {})
    results = [knob for knob in _candidates(robot, vary) if knob.fraction > 0.0]
    known = (
        set(TRUST)
        | {k.name for k in _candidates(robot, {})}
        | {k.part for k in _candidates(robot, {})}
    )
    for name, fraction in vary.items():
        if name not in known:
            raise DiagnosisError(
                f"--vary {name}: no such figure; there are {', '.join(sorted(known))}",
                where=f"robot {robot.name}",
                fix="name a kind, a part, or a kind and a part as mass:pole",
            )
        if not (math.isfinite(fraction) and 0.0 <= fraction <= 50.0):
            raise DiagnosisError(
                f"--vary {name}={fraction}: a fraction is between 0 and 50",
                where=f"robot {robot.name}",
                fix="give 0.1 for ten percent",
            )
    return tuple(that_matter(robot, results))


def _candidates(robot: Robot, vary: Mapping[str, float]) -> list[Knob]:
    spec = spec_of(robot)
    listed: list[tuple[str, str, str]] = []
    for link in robot.links:
        listed += [(kind, link.name, kind) for kind in ("mass", "com", "inertia")]
    for actuator in robot.actuators:
        listed.append(("gain", actuator.name, "gain"))
        if spec.actuator(actuator.name).biasprm[2] != 0.0:
            listed.append(("gain", actuator.name, "rate_gain"))
    for joint in robot.joints:
        if joint.kind in {"hinge", "slide"}:
            for figure in ("damping", "armature", "frictionloss", "stiffness"):
                if np.any(getattr(spec.joint(joint.name), figure)):
                    listed.append(("joint", joint.name, figure))
    return [_knob(*each, vary) for each in listed]


def _knob(kind: str, part: str, what: str, vary: Mapping[str, float]) -> Knob:
    fractions = (vary[name] for name in (f"{what}:{part}", part, kind) if name in vary)
    fraction = next(fractions, None)
    return Knob(
        kind=kind, part=part, what=what,
        fraction=TRUST[kind] if fraction is None else fraction,
        guessed=fraction is None and kind == "joint",
    )  # fmt: skip


def that_matter(robot: Robot, results: list[Knob]) -> list[Knob]:
    """Leave out figures that change neither inertia, gravity nor drive: a cart's own turning."""
    rng = np.random.default_rng(0)
    nominal = spec_of(robot).compile()
    positions = [nominal.qpos0 + rng.uniform(-1, 1, nominal.nq) for _ in range(3)]

    def forces(model: Any) -> np.ndarray[Any, Any]:
        data, rows = mujoco.MjData(model), []
        model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONSTRAINT.value
        # At its limit a servo hides what its gain changes.
        model.actuator_forcelimited[:] = False
        for position in positions:
            data.qpos[:], data.qvel[:], data.qacc[:] = position, 1.0, 1.0
            data.ctrl[:] = 0.5
            mujoco.mj_normalizeQuat(model, data.qpos)
            mujoco.mj_inverse(model, data)
            inverse = data.qfrc_inverse.copy()
            mujoco.mj_fwdActuation(model, data)
            rows.append(np.concatenate([inverse, data.qfrc_actuator, model.dof_frictionloss]))
        return np.array(rows)

    reference = forces(nominal)
    kept = []
    for knob in results:
        spec = spec_of(robot)
        knob.edit(spec, 0.1)
        if np.abs(forces(spec.compile()) - reference).max() > 1e-9 * np.abs(reference).max():
            kept.append(knob)
    return kept
