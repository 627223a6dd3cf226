from __future__ import annotations

import json
import re
import signal
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from morph.app.cli.main import main
from morph.body.load import load
from morph.record.write import write
from morph.sim.simulator import Simulator

Lines = list[str]
MESSAGE = re.compile(r"error: (?P<where>.+?): (?P<what>.+)\n  fix: (?P<fix>.+)\n")


@pytest.fixture(scope="module")
def swing() -> Lines:
    """The lines of a clean recording of the pendulum: 5 s at 100 Hz, one command."""
    run = Simulator(load("pendulum"), step=0.01).run(
        seconds=5.0,
        start={"hinge": 0.4},
        command={"hinge": lambda times: 0.5 * np.sin(7.0 * times)},
    )
    time = run.channel("hinge.position").time
    noise = np.random.default_rng(0).normal(0.0, 2e-4, len(time))
    told = run.channel("hinge.command").at(time)
    rows = zip(time.tolist(), (run["hinge.position"] + noise).tolist(), told.tolist(), strict=True)
    return ["time,hinge.position,hinge.command", *(f"{t!r},{q!r},{u!r}" for t, q, u in rows)]


def save(path: Path, lines: Lines) -> Path:
    path.write_text("\n".join(lines) + "\n")
    return path


def binding(folder: Path, lines: Lines, unit: str) -> Path:
    save(folder / "run.csv", lines)
    return save(
        folder / "rig.toml",
        [
            "[[episode]]",
            'file = "run.csv"',
            "[columns]",
            'time = { column = "time", unit = "s" }',
            f'"hinge.position" = {{ column = "hinge.position", unit = "{unit}" }}',
            '"hinge.command" = { column = "hinge.command", unit = "N m" }',
        ],
    )


def refused(capsys: pytest.CaptureFixture[str], out: Path, *arguments: str | Path) -> re.Match[str]:
    """Return the one message of a command that must be refused before it wrote anything."""
    before = sorted(out.parent.iterdir())
    status = main(["diagnose", *map(str, arguments), "--out", str(out), "--quiet"])
    said = capsys.readouterr()
    assert status == 2
    assert said.out == ""
    assert "Traceback" not in said.err
    found = MESSAGE.fullmatch(said.err)
    assert found, said.err
    assert sorted(out.parent.iterdir()) == before
    return found


def spoilt(row: int, column: int, text: str) -> Callable[[Lines], Lines]:
    def spoil(lines: Lines) -> Lines:
        cells = lines[row].split(",")
        cells[column] = text
        return [*lines[:row], ",".join(cells), *lines[row + 1 :]]

    return spoil


@pytest.mark.parametrize(
    ("spoil", "what", "where"),
    [
        # 10 of 501 samples; at most one in a hundred is dropped with a note.
        (
            lambda lines: [
                *lines[:50],
                *(f"{0.01 * k:.2f},nan,0.0" for k in range(49, 59)),
                *lines[60:],
            ],
            "hinge.position.* in 10 of 501",
            "run.csv, lines 51, 52",
        ),
        (spoilt(5, 0, "0.01"), "clock runs backwards", "run.csv, line 6"),
        (spoilt(0, 2, "hinge.command.x"), "hinge.command", "run.csv"),
        (spoilt(0, 1, "hindge.position"), "no joint of pendulum; its joints are hinge", "run.csv"),
        (spoilt(0, 2, "hinge.velocity"), "no channel 'hinge.command'", "run"),
        (spoilt(0, 1, "hinge.velocity"), "no channel 'hinge.position'", "run"),
        (lambda lines: lines[:1], "no samples", "run.csv, line 1"),
    ],
    ids=[
        "nan",
        "clock",
        "quantity",
        "unknown channel",
        "no command",
        "no position",
        "no samples",
    ],
)
def test_a_spoilt_recording_is_refused_where_it_is_spoilt(
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    swing: Lines,
    spoil: Callable[[Lines], Lines],
    what: str,
    where: str,
) -> None:
    path = save(tmp_path / "run.csv", spoil(swing))
    said = refused(capsys, tmp_path / "out", "pendulum", path)
    assert re.search(what, said["what"])
    assert where in said[0].splitlines()[0]


def test_an_empty_file_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "run.csv"
    path.touch()
    said = refused(capsys, tmp_path / "out", "pendulum", path)
    assert said["where"] == str(path)
    assert "empty" in said["what"]


@pytest.mark.parametrize("name", ["run.csv.gz", "run.npz", "run.parquet"])
def test_half_a_file_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], name: str
) -> None:
    path = write(Simulator(load("pendulum")).run(seconds=1.0), tmp_path / name)
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    said = refused(capsys, tmp_path / "out", "pendulum", path)
    assert str(path) in said["where"]


def test_a_recording_that_is_not_there_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    said = refused(capsys, tmp_path / "out", "pendulum", tmp_path / "gone.csv")
    assert "gone.csv" in said["where"]


def test_an_unknown_unit_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], swing: Lines
) -> None:
    said = refused(capsys, tmp_path / "out", "pendulum", binding(tmp_path, swing, "furlong"))
    assert "furlong" in said["what"]
    assert said["where"].endswith("rig.toml:5")


def test_a_copy_cannot_be_held_out(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], swing: Lines
) -> None:
    one, other = (save(tmp_path / f"{name}.csv", swing) for name in ("one", "other"))
    out = tmp_path / "out"
    said = refused(capsys, out, "pendulum", one, "--held-out", other)
    assert "identical" in said["what"]


@pytest.mark.parametrize(
    "description",
    [
        "<mujoco><worldbody><body><joint type='hinge'/></body></worldbody></mujoco>",
        "<mujoco><worldbody>",
        "",
    ],
    ids=["no mass", "cut off", "nothing"],
)
def test_a_description_that_does_not_compile_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], swing: Lines, description: str
) -> None:
    robot = tmp_path / "arm.xml"
    robot.write_text(description)
    said = refused(capsys, tmp_path / "out", robot, save(tmp_path / "run.csv", swing))
    assert "arm.xml" in said["where"]


def test_a_robot_that_is_not_on_the_shelf_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], swing: Lines
) -> None:
    said = refused(capsys, tmp_path / "out", "pendulem", save(tmp_path / "run.csv", swing))
    assert "pendulem" in said["what"]
    assert "pendulum" in said[0]


@pytest.mark.parametrize(
    ("option", "values"),
    [
        ("--held-out", ["nonsense"]),
        ("--only", ["nonsense"]),
        ("--horizon", ["nonsense"]),
        ("--horizon", ["0.01"]),
        ("--horizon", ["nan"]),
        ("--horizon", ["-1"]),
        ("--horizon", ["3.5"]),  # Only 1.25 s are held out.
        ("--vary", ["nonsense"]),
        ("--vary", ["nonsense=0.1"]),
        ("--vary", ["mass=nan"]),
        ("--vary", ["mass=-0.1"]),
        ("--vary", ["mass="]),
        ("--vary", ["=0.1"]),
        ("--budget", ["0"]),
        ("--budget", ["nan"]),
        ("--world", ["water"]),
    ],
    ids=lambda given: " ".join(given) if isinstance(given, list) else given,
)
def test_an_option_that_makes_no_sense_is_refused_by_name(
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    swing: Lines,
    option: str,
    values: list[str],
) -> None:
    path = save(tmp_path / "run.csv", swing)
    said = refused(capsys, tmp_path / "out", "pendulum", path, option, *values)
    assert option in said[0]


def test_an_out_that_is_a_file_is_refused_and_kept(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], swing: Lines
) -> None:
    out = tmp_path / "out"
    out.write_text("mine")
    said = refused(capsys, out, "pendulum", save(tmp_path / "run.csv", swing))
    assert said["where"] == str(out)
    assert out.read_text() == "mine"


@pytest.mark.parametrize(
    "during", ["morph.inference.diagnose.diagnose", "morph.app.report.files.write_whole"]
)
def test_an_interrupt_leaves_nothing_behind(
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    swing: Lines,
    during: str,
) -> None:
    def interrupted(*arguments: object, **options: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(during, interrupted)
    path, out = save(tmp_path / "run.csv", swing), tmp_path / "out"
    status = main(
        ["diagnose", "pendulum", str(path), "--out", str(out), "--quiet", "--budget", "0.5"]
    )
    said = capsys.readouterr()
    assert status == 130
    assert said.out == ""
    assert said.err == "interrupted; nothing was written\n"
    assert [file.name for file in tmp_path.iterdir()] == ["run.csv"]


def test_a_spent_budget_still_writes_the_best_answer_and_says_so(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], swing: Lines
) -> None:
    path, out = save(tmp_path / "run.csv", swing), tmp_path / "out"
    # Half a microsecond is spent before anything is looked for.
    status = main(
        ["diagnose", "pendulum", str(path), "--out", str(out), "--quiet", "--budget", "5e-7"]
    )
    assert status == 3
    assert "ended before it had tried all" in capsys.readouterr().out
    written = json.loads((out / "diagnosis.json").read_text())
    assert written["stopped_short"] is True
    assert (out / "report.html").stat().st_size > 1000


def test_one_interrupt_writes_the_best_answer_and_two_end_at_once(
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    swing: Lines,
) -> None:
    path, out = save(tmp_path / "run.csv", swing), tmp_path / "out"
    times, told, _ = 1, list[str](), signal.signal(signal.SIGINT, signal.default_int_handler)

    def interrupted(_progress: object, what: str, _share: float) -> None:
        told.append(what)
        if what.startswith("looking for what is missing"):
            for _ in range(times):
                signal.raise_signal(signal.SIGINT)

    monkeypatch.setattr("morph.app.cli.diagnose._Progress.__call__", interrupted)
    assert main(["diagnose", "pendulum", str(path), "--out", str(out)]) == 3
    said = capsys.readouterr()
    assert "The best answer so far will be written" in said.err
    assert json.loads((out / "diagnosis.json").read_text())["stopped_short"] is True
    assert "looking for changes" not in told
    times, before = 2, (out / "diagnosis.json").read_text()
    assert main(["diagnose", "pendulum", str(path), "--out", str(out)]) == 130
    assert capsys.readouterr().err.endswith("interrupted; nothing was written\n")
    assert (out / "diagnosis.json").read_text() == before
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
