"""Laws of joints, drives and sensors, as `effects.md` states them."""

from __future__ import annotations

import numpy as np

from experiments.concealed.law import Figures, Law, Setting, fields
from experiments.concealed.mechanism import TORQUE, Mechanism
from experiments.concealed.plant import Plant


def _add_viscous(plant: Plant, i: int, f: Figures) -> Plant:
    return plant.with_joint(i, viscous=plant.of_joint("viscous")[i] + f["b"])


def _add_rotor(plant: Plant, i: int, f: Figures) -> Plant:
    return plant.with_joint(i, rotor=plant.of_joint("rotor")[i] + f["J"])


def _scale_gain(plant: Plant, i: int, f: Figures) -> Plant:
    return plant.with_joint(i, gain=plant.of_joint("gain")[i] * f["gain"])


def _backlash(plant: Plant, i: int, f: Figures) -> Plant:
    return plant.with_joint(
        i, split=1.0, gap=f["gap"], spring_k=f["tooth_k"], spring_d=f["tooth_d"]
    )


def _spring(plant: Plant, i: int, f: Figures) -> Plant:
    return plant.with_joint(i, split=1.0, spring_k=f["k"], spring_d=f["d"])


def _waves(number: float, x: Setting) -> float:
    """Return a whole number of waves a turn, or ten times as many radians for a metre."""
    return float(int(number) * (10 if x.mechanism.plant.slide[x.place] else 1))


def _has_rotor(mechanism: Mechanism, i: int) -> bool:
    return bool(mechanism.plant.of_joint("rotor")[i] > 0 and mechanism.plant.of_joint("drive")[i])


def _sensed(mechanism: Mechanism, i: int) -> bool:
    """A torque drive that moves along gravity or along a rail looks the same from everywhere."""
    plant = mechanism.plant
    if plant.slide[i]:
        return False
    upright = abs((plant.rotation[0] @ plant.axis[0])[2]) > 0.99
    return not (i == 0 and upright and plant.of_joint("drive")[i] == TORQUE)


def _series(size: float, x: Setting) -> Figures:
    # Deflection under the usual load is 0.1 rad times the size; never stiffer than 700 rad/s.
    k = min(x.of("effort") / (0.1 * size), x.of("pair") * 700.0**2)
    ratio = 0.05 + 0.25 * x.chance[0]
    return {"k": k, "d": float(2 * ratio * np.sqrt(k * x.of("pair")))}


def _play(size: float, x: Setting) -> Figures:
    k = x.of("pair") * 500.0**2
    return {
        "gap": 0.5 * size * x.of("spread"),
        "tooth_k": k,
        "tooth_d": float(0.4 * np.sqrt(k * x.of("pair"))),
    }


def _patchy(plant: Plant, i: int, f: Figures) -> Plant:
    return plant.with_joint(
        i, patch=f["c"], patch_depth=f["a"] / f["c"], patch_n=f["n"], patch_phase=f["phase"]
    )


def _stop(size: float, x: Setting) -> Figures:
    inside = 0.45 * size * (x.of("high") - x.of("low"))
    k = min(x.of("peak") / 0.02, x.of("inertia") * 300.0**2)
    return {
        "q_stop": x.of("high") - inside if x.side > 0 else x.of("low") + inside,
        "side": x.side,
        "stop_k": k,
        "stop_d": float(np.sqrt(k * x.of("inertia"))),
    }


JOINT_LAWS = (
    Law(
        name="viscous_friction", kind="joint", apply=_add_viscous,
        figures=lambda s, x: {"b": s * x.of("effort") / x.of("speed")},
    ),
    Law(
        name="coulomb_friction", kind="joint", apply=fields(c="coulomb"), largest=0.8,
        figures=lambda s, x: {"c": s * x.of("effort")},
    ),
    Law(
        name="stribeck_friction", kind="joint", largest=0.6,
        apply=fields(c="coulomb", s="stiction", vs="stribeck"),
        figures=lambda s, x: {
            "c": s * x.of("effort"),
            "s": s * x.of("effort") * (1.4 + 1.1 * x.chance[0]),
            "vs": x.of("speed") * (0.05 + 0.3 * x.chance[1]),
        },
    ),
    Law(
        name="load_dependent_friction", kind="joint", largest=0.5,
        apply=fields(c0="load_c", k="load_k"),
        figures=lambda s, x: {"c0": 0.5 * s * x.of("effort") * x.chance[0], "k": s},
        acts=lambda m, i: bool(m.plant.of_joint("drive")[i]),
    ),
    Law(
        name="position_dependent_friction", kind="joint", largest=0.5,
        apply=_patchy,
        figures=lambda s, x: {
            "c": s * x.of("effort"),
            "a": s * x.of("effort") * (0.5 + 0.5 * x.chance[0]),
            "n": _waves(3 + 7 * x.chance[1], x),
            "phase": 2 * np.pi * x.chance[2],
        },
    ),
    Law(
        name="quadratic_damping", kind="joint", apply=fields(b2="quadratic"),
        figures=lambda s, x: {"b2": s * x.of("effort") / x.of("speed") ** 2},
    ),
    Law(
        name="joint_stiffness", kind="joint", apply=fields(k="stiffness", q0="rest"),
        figures=lambda s, x: {
            "k": s * x.of("effort") / x.of("spread"),
            "q0": x.of("middle") + (x.chance[0] - 0.5) * x.of("spread"),
        },
    ),
    Law(
        name="cogging", kind="joint", apply=fields(a="cog", n="cog_n", phase="cog_phase"),
        figures=lambda s, x: {
            "a": s * x.of("effort"),
            "n": _waves(4 + 20 * x.chance[0], x),
            "phase": 2 * np.pi * x.chance[1],
        },
    ),
    Law(
        name="hysteresis", kind="joint", apply=fields(F="loop", d="loop_way"), largest=0.8,
        figures=lambda s, x: {
            "F": s * x.of("effort"), "d": x.of("spread") * (0.05 + 0.3 * x.chance[0]),
        },
    ),
    Law(
        name="backlash", kind="joint", apply=_backlash, figures=_play, acts=_has_rotor,
        given=("tooth_k", "tooth_d"),
    ),
    Law(name="series_elasticity", kind="joint", apply=_spring, figures=_series, acts=_has_rotor),
    Law(
        name="end_stop", kind="joint", figures=_stop, given=("side", "stop_k", "stop_d"),
        apply=fields(q_stop="stop", side="stop_side", stop_k="stop_k", stop_d="stop_d"),
    ),
    Law(
        name="armature", kind="joint", apply=_add_rotor, largest=2.0,
        least=lambda x: 1.3 * x.vary["inertia"] + 0.05,
        figures=lambda s, x: {"J": s * x.of("inertia")},
    ),
)  # fmt: skip


def _driven(mechanism: Mechanism, i: int) -> bool:
    return bool(mechanism.plant.of_joint("drive")[i])


ACTUATOR_LAWS = (
    Law(
        name="actuator_delay", kind="actuator", apply=fields(T="delay"), acts=_driven,
        figures=lambda s, x: {"T": 0.1 * s},
    ),
    Law(
        name="actuator_lag", kind="actuator", apply=fields(T="lag"), acts=_driven,
        figures=lambda s, x: {"T": 0.1 * s},
    ),
    Law(
        name="torque_scale", kind="actuator", apply=_scale_gain, acts=_driven,
        least=lambda x: (x.vary["gain"] + 0.08) / 0.6,
        figures=lambda s, x: {"gain": 1 + 0.6 * s * x.side},
        beside=lambda f, described, true, i: {
            "gain": f["gain"] * float(true.of_joint("gain")[i] / described.of_joint("gain")[i])
        },
    ),
    Law(
        name="torque_saturation", kind="actuator", apply=fields(limit="limit"), acts=_driven,
        figures=lambda s, x: {"limit": x.of("peak") * (1 - 0.85 * s)},
    ),
    Law(
        name="speed_torque_limit", kind="actuator", apply=fields(tau0="stall", v0="no_load"),
        acts=_driven, largest=1.5,
        figures=lambda s, x: {
            "tau0": x.of("peak") * (1.1 + 0.4 * x.chance[0]), "v0": x.of("fast") / s,
        },
    ),
    Law(
        name="back_emf", kind="actuator", apply=fields(k="emf"), acts=_driven,
        figures=lambda s, x: {"k": s * x.of("effort") / x.of("speed")},
    ),
    Law(
        name="thermal_derating", kind="actuator", acts=_driven,
        apply=fields(rate="heat_rate", floor="heat_floor", level="heat_level"),
        # While it warms up only (1 - floor) rate / level^2 shows.
        given=("rate", "floor", "level"),
        figures=lambda s, x: {
            "rate": 3.0 * s / x.seconds, "floor": 0.3 + 0.4 * x.chance[0], "level": x.of("effort"),
        },
    ),
    Law(
        name="voltage_sag", kind="actuator", acts=_driven,
        # It acts on every drive; the case names the first.
        apply=lambda plant, i, f: plant.with_joint(slice(None), sag=f["k"]),
        figures=lambda s, x: {"k": s / float(x.scales.effort.sum())},
    ),
    Law(
        name="dead_zone", kind="actuator", apply=fields(threshold="dead"), acts=_driven,
        figures=lambda s, x: {"threshold": s * x.of("effort")},
    ),
)  # fmt: skip

SENSOR_LAWS = (
    Law(
        name="sensor_bias", kind="sensor", apply=fields(bias="bias"), acts=_sensed,
        figures=lambda s, x: {"bias": 0.2 * s * x.side},
    ),
    Law(
        name="sensor_scale", kind="sensor", apply=fields(scale="scale"), largest=1.0,
        figures=lambda s, x: {"scale": 1 + 0.3 * s * x.side},
    ),
    Law(
        name="timestamp_offset", kind="sensor", apply=fields(T="shift"),
        figures=lambda s, x: {"T": 0.1 * s},
    ),
)  # fmt: skip
