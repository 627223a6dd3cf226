from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from morph.errors import TransferError
from morph.policy_transfer.link.journal import Journal


def entries(path: Path) -> list[dict[str, object]]:
    journal = Journal(path)
    try:
        return journal.entries
    finally:
        journal.close()


def filled(path: Path, count: int = 3) -> bytes:
    journal = Journal(path)
    for number in range(count):
        journal.add({"number": number, "text": "a line\nbreak"})
    journal.close()
    return path.read_bytes()


def test_a_journal_cut_off_at_any_byte_holds_all_whole_entries(tmp_path: Path) -> None:
    path = tmp_path / "out.journal"
    data = filled(path)
    ends = [at + 1 for at, byte in enumerate(data) if byte == ord("\n")]
    assert len(ends) == 3
    for size in range(len(data) + 1):
        path.write_bytes(data[:size])
        whole = sum(end <= size for end in ends)
        assert [each["number"] for each in entries(path)] == list(range(whole)), size
        # The rest is gone from the file too, so that the next entry stands on its own line.
        assert path.read_bytes() == data[: ([0, *ends])[whole]]


def test_an_entry_after_a_kill_is_read_again(tmp_path: Path) -> None:
    path = tmp_path / "out.journal"
    path.write_bytes(filled(path)[:-5])
    journal = Journal(path)
    journal.add({"number": 7})
    journal.close()
    assert [each["number"] for each in entries(path)] == [0, 1, 7]


def test_a_spoilt_entry_that_others_follow_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "out.journal"
    data = bytearray(filled(path))
    data[data.index(b"\n") + 70] ^= 1
    path.write_bytes(data)
    with pytest.raises(TransferError, match=r"line 2 is spoilt, and lines follow it"):
        Journal(path)
    # Nothing was cut off, and the file is not held.
    assert path.read_bytes() == data
    path.write_bytes(data[: data.index(b"\n") + 1])
    assert len(entries(path)) == 1


def test_one_process_at_a_time_holds_a_journal(tmp_path: Path) -> None:
    path = tmp_path / "out.journal"
    journal = Journal(path)
    with pytest.raises(TransferError, match=r"is held by another process"):
        Journal(path)
    journal.rewrite([{"number": 5}])
    with pytest.raises(TransferError, match=r"is held by another process"):
        Journal(path)
    journal.add({"number": 6})
    journal.close()
    assert entries(path) == [{"number": 5}, {"number": 6}]


def test_a_folder_that_cannot_be_made_is_refused(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(TransferError, match=r"cannot be used: "):
        Journal(tmp_path / "file" / "out.journal")


ADDING = """
import sys
from pathlib import Path
from morph.policy_transfer.link.journal import Journal
journal = Journal(Path(sys.argv[1]))
number = 0
while True:
    journal.add({"number": number, "filling": "x" * 3000})
    number += 1
    print(number, flush=True)
"""


def test_what_was_added_before_a_kill_is_there(tmp_path: Path) -> None:
    path = tmp_path / "out.journal"
    with subprocess.Popen(
        [sys.executable, "-c", ADDING, str(path)], stdout=subprocess.PIPE, text=True
    ) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "1\n"
        assert [process.stdout.readline() for _ in range(20)][-1] == "21\n"
        process.kill()
        said = process.stdout.read().split()
    added = int(said[-1]) if said else 21
    found = [each["number"] for each in entries(path)]
    # One more may have been added and not been said.
    assert len(found) in {added, added + 1}
    assert found == list(range(len(found)))
