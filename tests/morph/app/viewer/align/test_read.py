"""Whether only what our commands wrote is taken, whoever wrote it."""

from __future__ import annotations

import json
import os
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from morph.app.viewer.align.read import MOST_BYTES, story
from morph.errors import ViewError

Copy = Callable[..., Path]


def changed(*path: str | int, to: Any) -> Callable[[Any], None]:
    """Return what puts a value into a record."""

    def change(said: Any) -> None:
        *way, last = path
        for key in way:
            said = said[key]
        said[last] = to

    return change


def test_a_chain_is_told_hop_by_hop_with_the_parts_of_its_record(wrote: dict[str, Path]) -> None:
    found = story(wrote["transfer"])
    said = json.loads((wrote["transfer"] / "transfer.json").read_text())
    assert found.command == "transfer"
    assert list(found.chain) == said["chain"] == list(found.asked)
    for hop, record in zip(found.hops, said["hops"], strict=True):
        arrows = [(a.begin, a.end, a.weight) for a in hop.parts.states]
        assert arrows == [
            (a["from"], a["to"], a["weight"]) for a in record["relay"]["parts"]["states"]
        ]
        assert hop.scores["final"] == record["score"]["final"]
        assert hop.scores["scratch"] is None
        assert hop.map is not None
        assert hop.map.is_file()


def test_an_alignment_is_a_chain_of_one_hop(wrote: dict[str, Path]) -> None:
    found = story(wrote["align"])
    assert found.command == "align"
    assert found.chain == found.asked == ("cartpole", "rider_rigid_driven")
    assert story(wrote["align"] / "align.json").folder == wrote["align"]


@pytest.mark.parametrize(
    ("change", "what"),
    [
        (changed("schema", to="morph.transfer/2"), r"of the schema 'morph.transfer/2'"),
        (changed("hops", to=[]), r"make no chain"),
        (changed("hops", to={}), r"hops is \{\}, not a list"),
        (changed("hops", 1, "source", to="pendulum"), r"make no chain"),
        (changed("hops", 0, "source", to="x" * 201), r"not a text of at most 200"),
        (changed("hops", 0, "guard", "verdict", to="fine"), r"the verdict is 'fine'"),
        (changed("hops", 0, "guard", "probability", to=1.5), r"probability is 1.5, not from 0 to"),
        (changed("hops", 0, "map", to="../../map.npz"), r"its map is '../../map.npz'"),
        (changed("hops", 0, "samples", to=None), r"samples is None"),
        (changed("hops", 0, "relay", "parts", "states", 0, "weight", to=None), r"weight is None"),
        (changed("hops", 0, "relay", "parts", "states", 0, "weight", to=True), r"weight is True"),
        (
            changed("hops", 0, "relay", "parts", "states", 0, "weight", to=10**400),
            r"weight is 1000",
        ),
        (changed("hops", 0, "relay", "parts", "states", 0, "weight", to=float("nan")), r"is nan"),
        (changed("provenance", to=None), r"stands None, not an object"),
    ],
)
def test_a_record_that_nobody_of_ours_wrote_is_refused_with_its_place(
    copy: Copy, change: Callable[[Any], None], what: str
) -> None:
    with pytest.raises(ViewError, match=what) as caught:
        story(copy("transfer", change))
    assert "transfer.json" in caught.value.where
    assert "morph transfer" in caught.value.fix


def test_a_million_hops_are_refused_before_they_are_looked_at(copy: Copy) -> None:
    folder = copy("transfer", changed("hops", to=[0] * 1_000_000))
    with pytest.raises(ViewError, match=r"hops has 1000000 entries, where 99 may be"):
        story(folder)


def test_a_record_that_is_half_written_is_called_so(copy: Copy) -> None:
    record = copy("align") / "align.json"
    record.write_text(record.read_text()[:500])
    with pytest.raises(ViewError, match=r"not JSON, or only a part of it"):
        story(record.parent)


@pytest.mark.parametrize("text", ["[" * 100_000, "[]", "null", '"align"', "\x00\xff", ""])
def test_a_record_of_something_else_is_refused(copy: Copy, text: str) -> None:
    record = copy("align") / "align.json"
    record.write_text(text)
    with pytest.raises(ViewError, match=r"not JSON|not an object"):
        story(record.parent)


def test_a_record_larger_than_the_bound_is_not_read_whole(copy: Copy) -> None:
    record = copy("align") / "align.json"
    with record.open("r+b") as file:
        # A hole: it has the size, but takes no room on the disk.
        file.truncate(MOST_BYTES + 1)
    with pytest.raises(ViewError, match=rf"{MOST_BYTES} are read at most"):
        story(record.parent)


def test_a_pipe_in_place_of_a_record_is_not_waited_for(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "align.json")
    with pytest.raises(ViewError, match=r"it is a pipe, no regular file"):
        story(tmp_path)


@pytest.mark.parametrize("name", ["align.json", "maps/01_body_map.npz"])
def test_a_link_out_of_the_folder_is_not_followed(copy: Copy, name: str, tmp_path: Path) -> None:
    folder = copy("align")
    away = tmp_path / "away"
    (folder / name).rename(away)
    (folder / name).symlink_to(away)
    with pytest.raises(ViewError, match=r"a link that leads out of the folder") as caught:
        story(folder)
    assert caught.value.where == str(folder / name)


@pytest.mark.parametrize(
    ("name", "what"),
    [
        (None, r"there is no such folder"),
        ("notes.txt", r"it holds neither transfer.json nor align.json"),
        ("relay.json", r"the transfer in it has not ended"),
    ],
)
def test_a_folder_without_a_record_is_told_what_it_lacks(
    tmp_path: Path, name: str | None, what: str
) -> None:
    folder = tmp_path / "other"
    if name is not None:
        folder.mkdir()
        (folder / name).write_text("{}")
    with pytest.raises(ViewError, match=what) as caught:
        story(folder)
    assert re.search(r"--out|morph transfer", caught.value.fix)


def test_letters_that_cannot_be_shown_become_spaces(copy: Copy) -> None:
    folder = copy("align", changed("target", "name", to="rider\x1b[31m\u202ered"))
    assert story(folder).hops[0].target == "rider [31m red"


def test_a_body_that_was_only_recorded_is_told_from_one_that_was_simulated(copy: Copy) -> None:
    command = "morph align cartpole --source theirs.npz --task balance --out DIR"
    found = story(copy("align", changed("provenance", "command", to=command)))
    assert found.asked == (None, "cartpole")
    command = "morph align --source theirs.npz --target ours.npz --out DIR"
    record = found.folder / "align.json"
    said = json.loads(record.read_text())
    said["provenance"]["command"] = command
    record.write_text(json.dumps(said))
    assert story(found.folder).asked == (None, None)


def test_a_loop_is_told_without_a_map(copy: Copy) -> None:
    def looped(said: Any) -> None:
        (hop, *_) = said["hops"]
        hop |= {"map": "identity", "quality": None}
        del hop["relay"], said["provenance"]["inputs"]
        said["hops"] = [hop]

    found = story(copy("transfer", looped))
    assert found.command == "loop"
    assert found.hops[0].map is None
    assert found.hops[0].crossing is None
