"""A model's dynamics at each state of a motion, in compiled loops over MuJoCo's functions."""

from __future__ import annotations

import copy
import ctypes
import functools
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from morph.arrays import Array
from morph.native import engine, library
from morph.physics.fluid.kernel import flowing

SOURCE = Path(__file__).with_name("dynamics.c")
NUDGE = 1e-5
"""Step of the central differences, rad or m, and per s. Accelerations near 100 per s2 round to
1e-14, an error of 1e-9 in a derivative; truncation adds 1e-10 / 6 of the third derivative."""
STEPS = 3
"""Gauss-Newton steps that close a chain: of an error e of an angle e^2 is left by each."""
BOUND = (
    "mj_forwardSkip", "mj_inverse", "mj_fwdActuation", "mj_solveM", "mj_fwdPosition",
    "mj_fwdVelocity", "mj_integratePos", "mj_kinematics", "mj_comPos", "mj_tendon",
    "mj_transmission", "mj_jac", "mj_jacDot",
)  # fmt: skip
"""MuJoCo's functions that the loops call, in the order of `morph_dynamics_bind`."""


def accelerations(model: mujoco.MjModel, position: Array, velocity: Array, command: Array) -> Array:
    """Return a model's acceleration along a motion, per s2, shape (samples, dofs).

    Joints that follow others and closed chains are rigid. Other constraints are left out: dry
    friction, stops and contacts.

    Args:
        model: The model.
        position: rad or m, shape (samples, nq).
        velocity: Per s, shape (samples, dofs).
        command: Controls, shape (samples, actuators).

    Raises:
        KernelError: There is no C compiler, or it fails.
    """
    result = np.empty(np.shape(velocity))
    with _unconstrained(model) as free:
        _call("forward", free, len(result), *_packed(position, velocity, command), result)
    return result


def supplied(
    model: mujoco.MjModel, position: Array, velocity: Array, acceleration: Array, command: Array
) -> Array:
    """Return the actuators' force less that which a motion needs, N m or N, (samples, dofs).

    It is zero along a motion of the model itself. Constraints are left out.

    Args:
        model: The model.
        position: rad or m, shape (samples, nq).
        velocity: Per s, shape (samples, dofs).
        acceleration: Per s2, same shape.
        command: Controls, shape (samples, actuators).

    Raises:
        KernelError: There is no C compiler, or it fails.
    """
    result = np.empty(np.shape(velocity))
    motion = _packed(position, velocity, acceleration, command)
    with _unconstrained(model) as free:
        _call("supplied", free, len(result), *motion, result)
    return result


def jacobians(model: mujoco.MjModel, position: Array, velocity: Array, command: Array) -> Array:
    """Return [dqacc/dq, dqacc/dv, M^-1] along a motion, shape (samples, dofs, 3 dofs).

    Constraints are left out. Derivatives are central differences; dq is a move in the coordinates
    of the velocity, as `mj_integratePos` takes.

    Args:
        model: The model.
        position: Shape (samples, nq).
        velocity: Per s, shape (samples, dofs).
        command: Controls, shape (samples, actuators).

    Raises:
        KernelError: There is no C compiler, or it fails.
    """
    samples, dofs = np.shape(velocity)
    result = np.empty((samples, dofs, 3 * dofs))
    motion = _packed(position, velocity, command)
    with _unconstrained(model) as free:
        _call("jacobians", free, samples, ctypes.c_double(NUDGE), *motion, result)
    return result


def closed(model: mujoco.MjModel, position: Array) -> Array:
    """Return positions moved a little, to where closed chains close, shape (samples, nq).

    Args:
        model: The model.
        position: Near there, rad or m, shape (samples, nq).

    Raises:
        KernelError: There is no C compiler, or it fails.
    """
    result = np.array(position, dtype=np.float64, order="C")
    with _unconstrained(model) as free:
        _call("closed", free, len(result), ctypes.c_int(STEPS), result)
    return result


def transmissions(model: mujoco.MjModel, position: Array) -> tuple[Array, Array]:
    """Return the actuators' lengths and moments along a motion.

    Args:
        model: The model.
        position: Shape (samples, nq).

    Returns:
        Lengths, shape (samples, actuators), and generalized forces by the force of each, shape
        (samples, actuators, dofs).

    Raises:
        KernelError: There is no C compiler, or it fails.
    """
    length = np.empty((len(position), model.nu))
    moment = np.empty((len(position), model.nu, model.nv))
    with _unconstrained(model) as free:
        _call("transmissions", free, len(position), *_packed(position), length, moment)
    return length, moment


@dataclass(frozen=True, kw_only=True, eq=False)
class Kinematics:
    """How joints and bodies lie along a motion, in the world."""

    axes: Array
    """Spatial axis of each degree of freedom, angular before linear, shape (samples, dofs, 6)."""
    rates: Array
    """How these change, per s, same shape."""
    turned: Array
    """Axes of each body as columns, shape (samples, bodies, 3, 3)."""
    origin: Array
    """Origin of each body, m, shape (samples, bodies, 3)."""
    about: Array
    """The point about which the axes of its tree are, m, same shape."""


def kinematics(
    model: mujoco.MjModel, bodies: Sequence[int], position: Array, velocity: Array
) -> Kinematics:
    """Return how joints and some bodies lie along a motion.

    Args:
        model: The model.
        bodies: Indices of the bodies.
        position: Shape (samples, nq).
        velocity: Shape (samples, dofs).

    Raises:
        KernelError: There is no C compiler, or it fails.
    """
    samples, dofs = np.shape(velocity)
    result = Kinematics(
        axes=np.empty((samples, dofs, 6)),
        rates=np.empty((samples, dofs, 6)),
        turned=np.empty((samples, len(bodies), 3, 3)),
        origin=np.empty((samples, len(bodies), 3)),
        about=np.empty((samples, len(bodies), 3)),
    )
    ids = np.array(bodies, dtype=np.int32)
    motion = _packed(position, velocity)
    outputs = (result.axes, result.rates, result.turned, result.origin, result.about)
    _call("kinematics", model, samples, ctypes.c_int(len(ids)), ids, *motion, *outputs)
    return result


@contextmanager
def _unconstrained(model: mujoco.MjModel) -> Iterator[mujoco.MjModel]:
    """Give a copy of a model without constraints, and let its fluid flow."""
    free = copy.copy(model)
    free.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONSTRAINT.value
    with flowing(free):
        yield free


def _packed(*arrays: Array) -> list[Array]:
    return [np.ascontiguousarray(each, dtype=np.float64) for each in arrays]


def _call(name: str, model: mujoco.MjModel, samples: int, *arguments: Any) -> None:
    """Call a loop with a model, fresh data, the number of samples and arrays."""
    data = mujoco.MjData(model)
    pointers = [
        ctypes.c_void_p(each.ctypes.data) if isinstance(each, np.ndarray) else each
        for each in arguments
    ]
    function = getattr(_code(), f"morph_{name}")
    addresses = (ctypes.c_void_p(model._address), ctypes.c_void_p(data._address))
    function(*addresses, ctypes.c_int64(samples), *pointers)


@functools.lru_cache(maxsize=1)
def _code() -> ctypes.CDLL:
    """Return the compiled loops, bound to the MuJoCo of this process.

    Raises:
        KernelError: There is no C compiler, or it fails.
    """
    with library.kept_folder() as folder:
        path = engine.build(SOURCE, folder, name="dynamics")
        code = library.load(path, fix="delete it, so that it is built again")
    for name in ("forward", "supplied", "jacobians", "closed", "transmissions", "kinematics"):
        getattr(code, f"morph_{name}").restype = None
    code.morph_dynamics_bind(*engine.functions(BOUND))
    return code
