"""The compiled fluid: built once by the C compiler at hand, kept by content, given to MuJoCo."""

from __future__ import annotations

import contextlib
import ctypes
import functools
import itertools
import os
import platform
import subprocess
import tempfile
import threading
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import mujoco

from morph.body.pieces import cache_folder
from morph.errors import KernelError
from morph.files import sha256
from morph.physics.fluid import reference
from morph.physics.fluid.compiler import compilers, processor
from morph.physics.fluid.numbers import SIGNATURE, WIDTH
from morph.physics.fluid.private import changed_by_others, make_private
from morph.regular_file import read_regular

SOURCE = Path(__file__).with_name("kernel.c")
FLAGS = ("-O3", "-fPIC", "-shared", "-std=c99")
NATIVE = ("-march=native",)
"""Lets the compiler use all that this processor has; left out where it does not know how."""
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
        home = _home()
        if home is not None:
            return load(build(home))
        # What lies in a folder of others may be theirs; once loaded, the file is not needed.
        with tempfile.TemporaryDirectory(prefix="morph-") as folder:
            return load(build(Path(folder)))
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
    try:
        why = changed_by_others(path)
        if why:
            raise KernelError(
                f"is not loaded, as it may not be yours: {why}",
                where=str(path),
                fix=f"unset {NAMED}, or let it name a copy in a folder that you alone may write to",
            )
        # All links are followed, so that none can be turned after that look.
        library = ctypes.CDLL(str(path.resolve()))
        version, width = library.morph_fluid_version(), library.morph_fluid_width()
        library.morph_fluid_signature.restype = ctypes.c_double
        signature = library.morph_fluid_signature()
        function, bind = library.morph_fluid, library.morph_fluid_bind
    except (OSError, AttributeError) as error:
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
    engine = ctypes.CDLL(str(_engine()))
    bind(*(ctypes.cast(getattr(engine, name), ctypes.c_void_p) for name in BOUND))
    return function


def _home() -> Path | None:
    """Return the folder of kernels in the cache, or None if others could change what is in it."""
    folder = cache_folder() / "kernel"
    with contextlib.suppress(OSError):
        make_private(folder)
        if not changed_by_others(folder):
            return folder
    return None


def build(folder: Path | None = None) -> Path:
    """Return the compiled kernel, built first where a folder does not hold it yet.

    Its key is the content of the source and of MuJoCo's headers, and the processor: a new MuJoCo
    builds a new one, and so does another machine that shares the cache.

    Args:
        folder: By default that of the cache.

    Raises:
        KernelError: There is no C compiler, or it fails, or the folder cannot be written to.
    """
    headers = Path(mujoco.HEADERS_DIR).parent
    held = sorted(headers.glob("mujoco/*.h"))
    key = sha256(SOURCE, *held, " ".join(FLAGS), platform.platform(), processor())
    place = cache_folder() / "kernel" if folder is None else folder
    path = place / f"fluid-{mujoco.mj_version()}-{key[:20]}.so"
    if not _sound(path):
        _compile(path, headers)
    return path


def _sum_of(path: Path) -> Path:
    return path.with_suffix(".sha256")


def _sound(path: Path) -> bool:
    """Return whether a library is as it was built: one cut short would end this process."""
    try:
        return sha256(path) == read_regular(_sum_of(path), 100).decode()
    except (OSError, ValueError):
        return False


def _compile(path: Path, headers: Path) -> None:
    """Try each compiler in turn; the library appears whole or not at all."""
    tried = []
    for compiler, extra in itertools.product(compilers(), (NATIVE, ())):
        try:
            make_private(path.parent)
            with tempfile.TemporaryDirectory(dir=path.parent) as folder:
                made = Path(folder) / path.name
                flags = (*FLAGS, *extra, f"-I{headers}")
                _run([*compiler, *flags, str(SOURCE), "-o", str(made), "-lm"])
                _sum_of(made).write_text(sha256(made))
                os.replace(_sum_of(made), _sum_of(path))
                os.replace(made, path)
        except (OSError, subprocess.SubprocessError) as error:
            tried.append(f"{' '.join(compiler)}: {str(error)[:200]}")
        else:
            return
    raise KernelError(
        "; ".join(tried) or "there is no C compiler",
        where=str(path),
        fix="install a C compiler, or `pip install ziglang`, which brings one",
    )


def _run(command: Sequence[str]) -> None:
    done = subprocess.run(command, capture_output=True, text=True, timeout=300, check=False)
    if done.returncode:
        raise subprocess.SubprocessError(done.stderr.strip() or f"status {done.returncode}")


def _engine() -> Path:
    """Return MuJoCo's own library, which this process has loaded already."""
    folder = Path(mujoco.__file__).parent
    (path,) = [p for name in ("libmujoco*", "mujoco.dll") for p in folder.glob(name)]
    return path
