"""The compiled fluid, given to MuJoCo."""

from __future__ import annotations

import ctypes
import functools
import os
import threading
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import mujoco

from morph.errors import KernelError
from morph.native import engine, library
from morph.physics.fluid import reference
from morph.physics.fluid.numbers import SIGNATURE, WIDTH

SOURCE = Path(__file__).with_name("kernel.c")
NAMED = "MORPH_FLUID_KERNEL"
"""Environment variable: a library built elsewhere, or `numpy` to do without one."""
BOUND = ("mj_factorM", "mj_stackAllocNum", "mj_markStack", "mj_freeStack")
"""MuJoCo's functions that the kernel calls."""


class Loan:
    """To how many simulations, in whatever threads, the numpy version is lent."""

    lock = threading.RLock()
    users = 0


def install() -> bool:
    """Let MuJoCo call the fluid in every simulation of this process; models stay dry that are.

    Without a compiled kernel a warning says why, and `flowing` lends the numpy version.

    Returns:
        Whether the compiled kernel is installed, as `mujoco.batch` needs.

    Raises:
        KernelError: Somebody else's function stands in `mjcb_passive`.
    """
    # Loaded by two threads at once, it would be two functions that bar each other.
    with Loan.lock:
        kernel = _kernel()
        if kernel is not None:
            _put(kernel)
    return kernel is not None


@contextmanager
def flowing(model: mujoco.MjModel) -> Iterator[None]:
    """Let MuJoCo call the fluid of a model, at least as long as this lasts.

    A function in Python, as the numpy version is, cannot stay: while one is installed MuJoCo
    compiles no model and runs no batch, not even of dry ones.

    Raises:
        KernelError: Somebody else's function stands in `mjcb_passive`.
    """
    lent = len(reference.wet_bodies(model)) > 0 and not install()
    if lent:
        with Loan.lock:
            _put(reference.passive)
            Loan.users += 1
    try:
        yield
    finally:
        if lent:
            with Loan.lock:
                Loan.users -= 1
                # Whoever ends first must not leave the others dry.
                if Loan.users == 0:
                    mujoco.set_mjcb_passive(None)


def _put(fluid: Any) -> None:
    held = mujoco.get_mjcb_passive()
    if held is not None and _place(held) != _place(fluid):
        raise KernelError(
            "another function is installed as mjcb_passive, where the fluid belongs",
            where="MuJoCo",
            fix="remove it by mujoco.set_mjcb_passive(None), or make an effect of it",
        )
    if held is None:
        mujoco.set_mjcb_passive(fluid)


def _place(function: Any) -> Any:
    """Return what tells one callback from another: of a library's its address."""
    try:
        return ctypes.cast(function, ctypes.c_void_p).value
    except (ctypes.ArgumentError, TypeError):
        return function


@functools.lru_cache(maxsize=1)
def _kernel() -> Any:
    """Return the compiled function, or None after a warning that names the reason."""
    named = os.environ.get(NAMED)
    if named == "numpy":
        return None
    try:
        if named:
            return load(Path(named))
        with library.kept_folder() as folder:
            return load(engine.build(SOURCE, folder, name="fluid"))
    except KernelError as error:
        message = f"the fluid runs in numpy, slowly and without batches: {error}"
        warnings.warn(message, RuntimeWarning, stacklevel=3)
        return None


def load(path: Path) -> Any:
    """Return the fluid's function in a library, bound to the MuJoCo of this process.

    Raises:
        KernelError: It is no library, not this one, built for another MuJoCo, or others could
            have put it there.
    """
    fix = f"delete it, so that it is built again, or unset {NAMED}"
    alone = f"unset {NAMED}, or let it name a copy in a folder that you alone may write to"
    fluid = library.load(path, fix=alone)
    try:
        version, width = fluid.morph_fluid_version(), fluid.morph_fluid_width()
        fluid.morph_fluid_signature.restype = ctypes.c_double
        signature = fluid.morph_fluid_signature()
        function, bind = fluid.morph_fluid, fluid.morph_fluid_bind
    except AttributeError as error:
        raise KernelError(
            f"is no compiled fluid: {str(error)[:200]}", where=str(path), fix=fix
        ) from error
    if version != mujoco.mj_version() or (width, signature) != (WIDTH, SIGNATURE):
        raise KernelError(
            f"was compiled for MuJoCo {version} and {width} numbers a body, signed {signature}; "
            f"these are MuJoCo {mujoco.mj_version()} and {WIDTH}, signed {SIGNATURE}",
            where=str(path),
            fix=fix,
        )
    bind(*engine.functions(BOUND))
    return function
