"""Whole sets, fetched from a server that has the real files under their public addresses."""

from __future__ import annotations

import gzip
import io
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch

from experiments.data import main
from experiments.public.audit import files_below
from experiments.public.manifest import DataSet, data_root, load_sets

SETS = ("contactnets_cube", "poppy_torso", "solo", "urma_hexapod")
"""One that is converted, one with pointers of git LFS, one that is expanded, one that is plain."""


def publish(server: Any, whole: DataSet, folder: Path) -> None:
    """Put the files of a set, as they stand in a folder, under their public addresses."""
    for public in whole.files:
        data = (folder / public.file).read_bytes()
        if public.origin.repository:
            path = public.origin.url(public.path, "")
            server.files[path] = gzip.decompress(data) if public.form == "gzip" else data
        elif public.made is not None and public.made.by == "tosses":
            with np.load(io.BytesIO(data), allow_pickle=False) as held:
                for name in held:
                    torch.save(torch.from_numpy(held[name]), content := io.BytesIO())
                    path = public.made.origin.url(f"data/tosses_processed/{name}.pt", "")
                    server.files[path] = content.getvalue()


@pytest.mark.parametrize("name", SETS)
def test_a_set_is_laid_out_as_the_studies_expect_it(
    name: str,
    server: Any,
    tmp_path: Path,
    recordings: Path,
    real_robots: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    (whole,) = (one for one in load_sets() if one.name == name)
    original = data_root(whole.kind) / name
    if not original.is_dir():
        pytest.skip(f"there is no {original}")
    publish(server, whole, original)
    asked = ["--set", name, "--to", str(tmp_path), "--mirror", server.address]
    # One file is wrong at first: it alone is not written, and the status says so.
    wrong = next(path for path in server.files if not path.endswith((".pt", ".xacro")))
    right, server.files[wrong] = server.files[wrong], b"something else"
    assert main(asked) == 2
    assert f"not complete: {name}" in capsys.readouterr().err
    assert len(files_below(whole.folder(tmp_path))) == len(whole.files) - 1
    server.files[wrong] = right
    assert main(asked) == 0
    said = f"1 of {len(whole.files)} files fetched, {len(whole.files) - 1} were there"
    assert said in capsys.readouterr().out
    assert main(["--set", name, "--check", str(tmp_path)]) == 0
    assert files_below(whole.folder(tmp_path)) == sorted(
        set(files_below(original)) - set(whole.notes)
    )
