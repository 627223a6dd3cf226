"""Folders that `morph align` and `morph transfer` really wrote, and copies to spoil."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from morph.app.cli.main import main
from morph.app.viewer.view_request import ViewRequest
from morph.app.viewer.views.align import AlignView, maker

QUICK = ("--trials", "2", "--repeats", "0", "--scratch", "0", "--quiet")


@pytest.fixture(scope="session")
def wrote(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """Folders by the command that wrote them."""
    out = tmp_path_factory.mktemp("wrote")
    bodies = ("cartpole", "rider_rigid_driven")
    assert main(["align", *bodies, "--out", str(out / "align"), "--quiet"]) == 0
    chain = ("--from", "learned", "--chain", *bodies, "rider_three_links_driven")
    assert main(["transfer", *chain, "--out", str(out / "transfer"), *QUICK]) == 0
    return {name: out / name for name in ("align", "transfer")}


Change = Callable[[Any], Any]


@pytest.fixture
def copy(wrote: dict[str, Path], tmp_path: Path) -> Callable[..., Path]:
    """Copies a folder, its record changed by a function."""

    def copied(name: str, change: Change = lambda said: said) -> Path:
        folder = tmp_path / name
        shutil.copytree(wrote[name], folder)
        record = folder / f"{name}.json"
        said = json.loads(record.read_text())
        record.write_text(json.dumps(change(said) or said))
        return folder

    return copied


@pytest.fixture(scope="session")
def makers() -> dict[Path, Callable[[], Any]]:
    """What makes views, by the folder that it has loaded."""
    return {}


@pytest.fixture
def shown(
    wrote: dict[str, Path], makers: dict[Path, Callable[[], Any]]
) -> Callable[..., AlignView]:
    """Makes the view of a folder; what nobody spoils is loaded once."""

    def view(folder: Path) -> AlignView:
        if folder not in makers or folder not in wrote.values():
            makers[folder] = maker(ViewRequest(robots=(), asked=(), transfer=folder))
        made = makers[folder]()
        assert isinstance(made, AlignView)
        return made

    return view
