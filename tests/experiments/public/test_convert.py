"""Making the files that studies read: tosses from torch files that may hold anything."""

from __future__ import annotations

import io
import os
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch

from experiments.public.content import DataError, measure, verify
from experiments.public.convert import tosses
from experiments.public.manifest import load_sets

VALUES = np.random.default_rng(5).normal(size=(7, 19))


def saved(held: Any, *, legacy: bool = False) -> bytes:
    """Return what torch writes for an object."""
    content = io.BytesIO()
    torch.save(held, content, _use_new_zipfile_serialization=not legacy)
    return content.getvalue()


@pytest.mark.parametrize("legacy", [False, True])
def test_a_toss_keeps_its_values_to_the_bit(tmp_path: Path, legacy: bool) -> None:
    inputs = {
        "3.pt": saved(torch.from_numpy(VALUES), legacy=legacy),
        "12.pt": saved(torch.from_numpy(2.0 * VALUES)[None], legacy=legacy),
    }
    with np.load(io.BytesIO(tosses(tmp_path, inputs)), allow_pickle=False) as held:
        assert list(held) == ["3", "12"]
        np.testing.assert_array_equal(held["3"], VALUES)
        np.testing.assert_array_equal(held["12"], 2.0 * VALUES)


class Bomb:
    """Makes a folder when it is unpickled."""

    def __init__(self, path: Path) -> None:
        self.path = path

    def __reduce__(self) -> tuple[Any, ...]:
        return os.mkdir, (str(self.path),)


@pytest.mark.parametrize("legacy", [False, True])
def test_code_in_a_torch_file_does_not_run(tmp_path: Path, legacy: bool) -> None:
    bomb = saved(Bomb(tmp_path / "made"), legacy=legacy)
    with pytest.raises(DataError, match=r"0\.pt: is not a torch file of tensors"):
        tosses(tmp_path, {"0.pt": bomb})
    assert not (tmp_path / "made").exists()
    # The bomb is a real one: where code may run, it does.
    torch.load(io.BytesIO(bomb), weights_only=False)
    assert (tmp_path / "made").is_dir()


@pytest.mark.parametrize(
    ("held", "message"),
    [
        (torch.zeros(7, 18), r"holds Tensor \(7, 18\) instead of a tensor \(samples, 19\)"),
        (torch.zeros(19), r"holds Tensor \(19,\)"),
        (torch.zeros(2, 7, 19), "holds 2 tosses instead of one"),
        ([1.0, 2.0], r"holds list \(\)"),
    ],
)
def test_what_is_no_toss_is_refused(tmp_path: Path, held: object, message: str) -> None:
    with pytest.raises(DataError, match=rf"0\.pt: {message}"):
        tosses(tmp_path, {"0.pt": saved(held)})


def test_what_is_no_torch_file_is_refused(tmp_path: Path) -> None:
    for data in (b"", b"PK\3\4", b"<html>", saved(torch.zeros(7, 19))[:-40]):
        with pytest.raises(DataError, match=r"0\.pt: is not a torch file"):
            tosses(tmp_path, {"0.pt": data})


def test_the_cubes_tosses_are_made_anew_from_torch_files(recordings: Path, tmp_path: Path) -> None:
    (cube,) = (whole for whole in load_sets() if whole.name == "contactnets_cube")
    with np.load(recordings / "contactnets_cube" / "tosses.npz", allow_pickle=False) as held:
        values = {name: held[name] for name in held}
    (made,) = (public for public in cube.files if public.made)
    assert made.made is not None
    assert [f"{name}.pt" for name in values] == list(made.made.inputs)
    inputs = {f"{name}.pt": saved(torch.from_numpy(array)) for name, array in values.items()}
    verify(made, tosses(tmp_path, inputs), "tosses.npz")
    inputs["7.pt"] = saved(torch.from_numpy(np.nextafter(values["7"], 9.0)))
    with pytest.raises(DataError, match="has sha256"):
        verify(made, tosses(tmp_path, inputs), "tosses.npz")


def test_the_hash_of_arrays_does_not_depend_on_how_they_are_packed() -> None:
    loose, tight = io.BytesIO(), io.BytesIO()
    np.savez(loose, a=VALUES, b=VALUES[:2])
    np.savez_compressed(tight, b=VALUES[:2], a=VALUES)
    assert len(loose.getvalue()) > len(tight.getvalue())
    first = measure(loose.getvalue(), "npz", "loose.npz")
    assert measure(tight.getvalue(), "npz", "tight.npz") == first
    np.savez_compressed(other := io.BytesIO(), a=VALUES, c=VALUES[:2])
    assert measure(other.getvalue(), "npz", "other.npz")[1] != first[1]
    with pytest.raises(DataError, match="cannot be unpacked"):
        measure(b"no archive", "npz", "broken.npz")


def test_the_hash_of_a_description_depends_on_its_numbers_and_not_on_its_layout() -> None:
    text = b'<robot name="a"><link name="b" mass="1.0"/></robot>'
    laid_out = b'<?xml version="1.0"?>\n<!-- c -->\n' + text.replace(
        b'<link name="b" mass="1.0"/>', b'\n  <link mass="1.0" name="b"></link>\n'
    )
    first = measure(text, "xml", "a.urdf")
    assert measure(laid_out, "xml", "a.urdf") == first
    assert measure(text.replace(b"1.0", b"1.1"), "xml", "a.urdf") != first
