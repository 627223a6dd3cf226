"""How the compiled fluid is built, kept, loaded and done without."""

from __future__ import annotations

import ctypes
import json
import os
import subprocess
import sys
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest

from morph.body.load import load
from morph.body.spec import spec_of
from morph.errors import KernelError
from morph.native import engine
from morph.native import library as native
from morph.native.compilers import compilers
from morph.physics.fluid import kernel
from morph.physics.fluid.linear_drag import LinearDrag
from morph.physics.fluid.numbers import SIGNATURE, WIDTH
from morph.sim.rollout import rollout
from morph.sim.simulator import compiled

SWIM = """
import json, os, sys, warnings
import morph.native.library as native
from morph.body.load import load
from morph.errors import MorphError
from morph.physics.fluid.added_mass import AddedMass
from morph.physics.fluid.quadratic_drag import QuadraticDrag
from morph.sim.simulator import Simulator

if "nothing" in sys.argv:
    native.compilers = lambda: ()
robot, seconds = load("swimmer_three_links"), float(sys.argv[1])
water = tuple(
    effect
    for link in robot.links
    for effect in (
        AddedMass(body=link.name, y=3.0, rz=0.2, cx=-0.5),
        QuadraticDrag(body=link.name, y=5.0, rz=0.1, cx=-0.5),
    )
)
with warnings.catch_warnings(record=True) as told:
    warnings.simplefilter("always")
    runs = [
        Simulator(robot, effects).run(seconds=seconds, command={"front": 1.5, "rear": -1.0})
        for effects in (water, (), water)
    ]
ends = [[float(run[f"{j.name}.position"][-1]) for j in robot.joints] for run in runs]
print(json.dumps({"ends": ends, "told": [str(each.message) for each in told]}))
"""
"""A swimmer swims, then in no water at all, then again."""


def build() -> Path:
    """Build the fluid's kernel into the cache."""
    with native.kept_folder() as folder:
        return engine.build(kernel.SOURCE, folder, name="fluid")


def swum(*arguments: str, seconds: float = 0.02, **environment: str) -> dict[str, Any]:
    """Return how a swimmer ends in a process of its own, and which warnings it gave."""
    done = subprocess.run(
        [sys.executable, "-c", SWIM, str(seconds), *arguments],
        env={**os.environ, **environment},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    found: dict[str, Any] = json.loads(done.stdout)
    return found


def test_the_numpy_fluid_swims_as_the_compiled_one() -> None:
    fast, slow = swum(seconds=0.25), swum(seconds=0.25, MORPH_FLUID_KERNEL="numpy")
    assert fast["told"] == slow["told"] == []
    # 125 steps of sums in another order, each 1e-16 of its terms.
    assert np.array(slow["ends"]) == pytest.approx(np.array(fast["ends"]), abs=1e-9)
    wet, dry, again = (np.array(end) for end in fast["ends"])
    assert np.abs(wet - dry).max() > 0.1
    assert np.array_equal(wet, again)


def test_without_a_compiler_a_warning_says_what_to_install(tmp_path: Path) -> None:
    found = swum("nothing", MORPH_CACHE=str(tmp_path))
    assert found["ends"] == swum(MORPH_FLUID_KERNEL="numpy")["ends"]
    (told,) = found["told"]
    assert "the fluid runs in numpy, slowly" in told
    assert "there is no C compiler" in told
    assert "install a C compiler, or `pip install ziglang`" in told


def test_a_library_that_is_none_gives_a_warning_that_names_it(tmp_path: Path) -> None:
    path = tmp_path / "fluid.so"
    path.write_text("no library")
    (told,) = swum(MORPH_FLUID_KERNEL=str(path))["told"]
    assert str(path) in told
    assert "unset MORPH_FLUID_KERNEL" in told


@pytest.fixture
def _by_numpy(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Do without the compiled fluid."""
    held = mujoco.get_mjcb_passive()
    monkeypatch.setattr(kernel, "_kernel", lambda: None)
    mujoco.set_mjcb_passive(None)
    yield
    mujoco.set_mjcb_passive(held)


@pytest.mark.usefixtures("_by_numpy")
def test_a_dry_variant_beside_wet_ones_does_not_dry_them() -> None:
    robot = load("swimmer_three_links")
    drags = ((), (LinearDrag(body="tail", y=20.0),), (LinearDrag(body="tail", y=40.0),))
    variants = [compiled(spec_of(robot), effects, robot) for effects in drags]
    model = variants[0].model
    q, v = np.tile(model.qpos0, (3, 1)), np.ones((3, model.nv))
    found = rollout(variants, np.arange(3), q, v, np.zeros((3, 50, model.nu)))[1][:, -1]
    for each in range(3):
        alone = rollout([variants[each]], np.zeros(1, int), q[:1], v[:1], np.zeros((1, 50, 2)))
        assert np.array_equal(found[each], alone[1][0, -1])
    assert np.abs(found[0] - found[1]).max() > 0.01
    # And it is gone when nobody swims: MuJoCo compiles nothing while a function in Python stands.
    assert mujoco.get_mjcb_passive() is None


def library(folder: Path, compiler: tuple[str, ...], text: str) -> Path:
    """Return a library compiled from a text in C."""
    source, path = folder / "other.c", folder / "other.so"
    source.write_text(text)
    subprocess.run([*compiler, "-shared", "-fPIC", str(source), "-o", str(path)], check=True)
    return path


OTHER = """
int morph_fluid_version(void) {{ return {version}; }}
int morph_fluid_width(void) {{ return {width}; }}
double morph_fluid_signature(void) {{ return {signature}; }}
void morph_fluid(const void* m, void* d) {{ }}
void morph_fluid_bind(void* a, void* b, void* c, void* d) {{ }}
"""


@pytest.mark.parametrize(
    ("version", "width", "signature"),
    [
        (3003002, WIDTH, SIGNATURE),
        (mujoco.mj_version(), 41, SIGNATURE),
        (mujoco.mj_version(), WIDTH, 0.5),
        (0, 0, 0.0),
    ],
)
def test_a_library_for_another_mujoco_or_another_table_is_refused(
    tmp_path: Path, compiler: tuple[str, ...], version: int, width: int, signature: float
) -> None:
    source = OTHER.format(version=version, width=width, signature=signature)
    path = library(tmp_path, compiler, source)
    told = f"was compiled for MuJoCo {version} and {width} numbers a body, signed {signature}; "
    with pytest.raises(KernelError, match=told) as refused:
        kernel.load(path)
    assert refused.value.where == str(path)


def test_a_library_of_something_else_is_refused(tmp_path: Path, compiler: tuple[str, ...]) -> None:
    path = library(tmp_path, compiler, "int something_else(void) { return 0; }")
    with pytest.raises(KernelError, match="is no compiled fluid"):
        kernel.load(path)


@pytest.mark.parametrize("content", [None, b"", b"text", b"\x7fELF"])
def test_a_file_that_is_no_library_is_refused(tmp_path: Path, content: bytes | None) -> None:
    path = tmp_path / "fluid.so"
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(KernelError, match="is no library"):
        kernel.load(path)


def test_a_kernel_is_built_once_and_kept(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, compiler: tuple[str, ...]
) -> None:
    monkeypatch.setenv("MORPH_CACHE", str(tmp_path))
    # A compiler that fails is passed over.
    monkeypatch.setattr(native, "compilers", lambda: ((sys.executable, "-c", "1/0"), compiler))
    path = build()
    assert ctypes.CDLL(str(path)).morph_fluid_width() == WIDTH
    kept = [path.name, path.with_suffix(".sha256").name]
    assert sorted(each.name for each in path.parent.iterdir()) == sorted(kept)
    before = path.stat().st_mtime_ns
    monkeypatch.setattr(native, "compilers", tuple)
    assert build() == path
    assert path.stat().st_mtime_ns == before


def test_a_kernel_cut_short_in_the_cache_is_built_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, compiler: tuple[str, ...]
) -> None:
    monkeypatch.setenv("MORPH_CACHE", str(tmp_path))
    monkeypatch.setattr(native, "compilers", lambda: (compiler,))
    whole = (path := build()).read_bytes()
    # Loaded as it is, this ends the process by a bus error.
    path.write_bytes(whole[: len(whole) // 2])
    assert build() == path
    assert ctypes.CDLL(str(path)).morph_fluid_width() == WIDTH


def test_a_compiler_whose_quotation_is_not_closed_is_passed_over(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv("CC", '"cc')
    assert '"cc' not in [command[0] for command in compilers()]


def test_threads_that_ask_at_once_get_one_kernel(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, compiler: tuple[str, ...]
) -> None:
    monkeypatch.setenv("MORPH_CACHE", str(tmp_path))
    held = mujoco.get_mjcb_passive()
    mujoco.set_mjcb_passive(None)
    kernel._kernel.cache_clear()
    try:
        with ThreadPoolExecutor(8) as pool:
            assert all(pool.map(lambda _: kernel.install(), range(8)))
    finally:
        mujoco.set_mjcb_passive(None)
        mujoco.set_mjcb_passive(held)
        kernel._kernel.cache_clear()


@pytest.mark.usefixtures("_by_numpy")
def test_the_first_of_two_simulations_to_end_does_not_dry_the_other() -> None:
    robot = load("swimmer_three_links")
    model = compiled(spec_of(robot), (LinearDrag(body="tail", y=20.0),), robot).model
    with kernel.flowing(model):
        with kernel.flowing(model):
            pass
        assert mujoco.get_mjcb_passive() is not None
    assert mujoco.get_mjcb_passive() is None


def test_compilers_that_all_fail_are_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MORPH_CACHE", str(tmp_path))
    broken = (sys.executable, "-c", "raise SystemExit('no headers')")
    monkeypatch.setattr(native, "compilers", lambda: (broken, ("no-such-compiler",)))
    with pytest.raises(KernelError, match=r"no headers.*no-such-compiler"):
        build()


@pytest.fixture
def _somebody_else() -> Iterator[None]:
    held = mujoco.get_mjcb_passive()
    mujoco.set_mjcb_passive(lambda model, data: None)
    yield
    mujoco.set_mjcb_passive(held)


@pytest.mark.usefixtures("_somebody_else")
def test_somebody_elses_function_is_not_thrown_out() -> None:
    with pytest.raises(KernelError, match="another function is installed as mjcb_passive"):
        kernel.install()


def test_installing_twice_is_installing_once() -> None:
    assert kernel.install()
    held = mujoco.get_mjcb_passive()
    assert kernel.install()
    assert mujoco.get_mjcb_passive() is held
