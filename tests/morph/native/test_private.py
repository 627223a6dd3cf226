"""Compiled code is loaded from where nobody else could have put it."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from pathlib import Path

import mujoco
import pytest

from morph.errors import KernelError
from morph.native import engine
from morph.native import library as native
from morph.native.private import changed_by_others, make_private
from morph.physics.fluid import kernel


def build() -> Path:
    """Build the fluid's kernel into the cache."""
    with native.kept_folder() as folder:
        return engine.build(kernel.SOURCE, folder, name="fluid")


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A folder of one's own, two levels deep, with a file in it."""
    made = tmp_path / "above" / "own"
    make_private(made)
    (made / "code.so").write_bytes(b"code")
    (made / "code.so").chmod(0o644)
    return made


def test_what_lies_in_a_folder_of_ones_own_is_trusted(folder: Path) -> None:
    assert folder.stat().st_mode & 0o777 == 0o700
    assert folder.parent.stat().st_mode & 0o777 == 0o700
    assert changed_by_others(folder / "code.so") == changed_by_others(folder) == ""


@pytest.mark.parametrize("mode", [0o770, 0o702, 0o777, 0o1777])
def test_a_folder_that_others_may_write_to_is_named(folder: Path, mode: int) -> None:
    folder.chmod(mode)
    assert changed_by_others(folder / "code.so") == f"others may write to {folder.resolve()}"


@pytest.mark.parametrize(("mode", "trusted"), [(0o777, False), (0o1777, True), (0o755, True)])
def test_above_it_only_a_folder_where_owners_alone_remove_may_be_written_to(
    folder: Path, mode: int, trusted: bool
) -> None:
    folder.parent.chmod(mode)
    why = "" if trusted else f"others may write to {folder.parent.resolve()}"
    assert changed_by_others(folder / "code.so") == why


def test_a_file_that_others_may_write_to_is_named(folder: Path) -> None:
    (folder / "code.so").chmod(0o666)
    assert changed_by_others(folder / "code.so").endswith("code.so")


def test_a_link_counts_as_where_it_leads(folder: Path, tmp_path: Path) -> None:
    (tmp_path / "link.so").symlink_to(folder / "code.so")
    assert changed_by_others(tmp_path / "link.so") == ""
    folder.chmod(0o777)
    assert "others may write to" in changed_by_others(tmp_path / "link.so")


@pytest.mark.skipif(os.geteuid() != 0, reason="only root gives files away")
def test_a_file_of_another_user_is_named(folder: Path) -> None:
    os.chown(folder / "code.so", 4242, -1)
    assert changed_by_others(folder / "code.so").endswith("code.so belongs to user 4242")


@pytest.fixture
def _nothing_loaded() -> Iterator[None]:
    """Forget which kernel is loaded, before and after."""
    held = mujoco.get_mjcb_passive()
    mujoco.set_mjcb_passive(None)
    kernel._kernel.cache_clear()
    yield
    mujoco.set_mjcb_passive(None)
    mujoco.set_mjcb_passive(held)
    kernel._kernel.cache_clear()


@pytest.mark.usefixtures("_nothing_loaded")
def test_a_kernel_in_a_cache_that_others_may_write_to_is_compiled_anew_elsewhere(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, compiler: tuple[str, ...]
) -> None:
    monkeypatch.setenv("MORPH_CACHE", str(tmp_path))
    monkeypatch.setattr(native, "compilers", lambda: (compiler,))
    planted = build()
    # Were it loaded, as its sum is right, the process would end with status 66.
    source = tmp_path / "planted.c"
    source.write_text(
        "#include <stdlib.h>\n__attribute__((constructor)) void f(void) { exit(66); }"
    )
    native._run([*compiler, "-fPIC", "-shared", str(source), "-o", str(planted)])
    planted.with_suffix(".sha256").write_text(native.sha256(planted))
    planted.parent.chmod(0o777)
    before = sorted(each.name for each in planted.parent.iterdir())
    assert kernel.install()
    assert sorted(each.name for each in planted.parent.iterdir()) == before


def test_a_library_that_is_named_in_a_folder_of_others_is_refused_by_name(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, compiler: tuple[str, ...]
) -> None:
    monkeypatch.setenv("MORPH_CACHE", str(tmp_path / "cache"))
    monkeypatch.setattr(native, "compilers", lambda: (compiler,))
    shared, own = tmp_path / "shared", tmp_path / "own"
    for each, mode in ((shared, 0o777), (own, 0o700)):
        each.mkdir()
        each.chmod(mode)
        shutil.copy(build(), each / "fluid.so")
    with pytest.raises(KernelError, match=r"others may write to .*shared") as caught:
        kernel.load(shared / "fluid.so")
    assert caught.value.where == str(shared / "fluid.so")
    assert "a folder that you alone may write to" in caught.value.fix
    assert kernel.load(own / "fluid.so")
