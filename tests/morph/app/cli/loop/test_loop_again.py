from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from morph.app.cli.main import main

LONG = ("--change", "length:pole=1.2")


def test_an_interrupted_loop_goes_on_at_the_trial_it_was_in(
    capsys: pytest.CaptureFixture[str], bench: Any
) -> None:
    bench.loop(*LONG, "--quiet", out="whole")
    # The first advice leads to the second trial, and in the second it is interrupted.
    bench.knowing.calls, bench.knowing.interrupted = 0, 2
    bench.loop(*LONG, "--quiet", status=130)
    assert "after 2 trials; the same command goes on from there" in capsys.readouterr().err
    assert not Path("out/transfer.json").exists()
    kept = {name: at for name, at in bench.content().items() if name.endswith("experience.npz")}
    assert len(kept) == 2
    bench.knowing.interrupted = 0
    bench.loop(*LONG, "--quiet")
    after = bench.content()
    assert {name: after[name] for name in kept} == kept
    again, whole = bench.record()["hops"][0], bench.record("whole")["hops"][0]
    assert [each["loss"] for each in again["trials"]] == [each["loss"] for each in whole["trials"]]
    assert again["score"] == whole["score"]


def test_an_interrupt_before_the_first_trial_leaves_nothing(
    capsys: pytest.CaptureFixture[str], bench: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    def pressed(*_: Any, **__: Any) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("morph.search.target.Simulated.trial", pressed)
    bench.loop(*LONG, status=130)
    assert capsys.readouterr().err == "interrupted; nothing was written\n"
    assert not Path("out").exists()


def test_what_is_done_is_not_done_again(capsys: pytest.CaptureFixture[str], bench: Any) -> None:
    bench.loop(*LONG, "--quiet")
    before, calls = bench.content(), bench.knowing.calls
    capsys.readouterr()
    bench.loop(*LONG)
    assert "out holds this loop already, and it succeeded" in capsys.readouterr().out
    bench.loop(*LONG, "--json")
    assert capsys.readouterr().out == Path("out/transfer.json").read_text()
    assert bench.content() == before
    assert bench.knowing.calls == calls


def test_more_trials_go_on_from_those_that_were_made(bench: Any) -> None:
    bench.loop(*LONG, "--quiet", "--trials", "1", status=3)
    first = bench.content()["out/trials/00/experience.npz"]
    bench.loop(*LONG, "--quiet", "--trials", "2")
    assert bench.content()["out/trials/00/experience.npz"] == first
    assert len(bench.record()["hops"][0]["trials"]) == 2


def test_what_breaks_after_a_trial_leaves_what_was_found_and_says_so(
    capsys: pytest.CaptureFixture[str], bench: Any
) -> None:
    bench.knowing.failing = 2
    bench.loop(*LONG, "--quiet", status=3)
    assert "the search broke" in capsys.readouterr().out
    (hop,) = bench.record()["hops"]
    assert (len(hop["trials"]), hop["succeeded"], hop["why"]) == (1, False, "the search broke")


@pytest.mark.parametrize(
    ("others", "what"),
    [
        (("--seed", "1", *LONG), "another seed"),
        (("--change", "length:pole=1.3"), "another target"),
    ],
)
def test_a_folder_is_kept_for_its_own_loop(others: tuple[str, ...], what: str, bench: Any) -> None:
    bench.loop(*LONG, "--quiet", "--trials", "1", status=3)
    (Path("out") / "mine.txt").write_text("stays")
    with_policy = ("--policy", "weak", "--trials", "1", *others)
    bench._capsys.readouterr()
    found = bench.refused(*bench.words(*with_policy))
    assert what in found["what"]
    assert "--fresh" in found["fix"]
    assert main([*bench.words(*with_policy), "--fresh", "--quiet"]) == 3
    assert (Path("out") / "mine.txt").read_text() == "stays"
    said = json.loads((Path("out") / "loop.json").read_text())
    assert said["seed"] == ("1" if "--seed" in others else "0")
