from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from morph.body.load import load
from morph.errors import RecordingError
from morph.record.binding import load_binding
from morph.record.load import load_recordings

BINDING = """\
root = "logs"

[[episode]]
file = "run.csv"
session = "monday"

[columns]
time = { column = "stamp", unit = "us" }
"hip.position" = { column = "q", unit = "deg", scale = 2.0, offset = -90.0 }
"knee.position" = { column = 2, element = 1, unit = "rad" }
"hip.command" = { column = "tau", unit = "N m" }
"""


def rig(folder: Path, text: str = BINDING) -> Path:
    logs = folder / "logs"
    logs.mkdir(exist_ok=True)
    rows = [f'{20000 * at}, {at}, "[0.5, {at / 8}]", {at}' for at in range(12)]
    (logs / "run.csv").write_text("\n".join(["stamp, q, list, tau", *rows]) + "\n")
    path = folder / "recording.toml"
    path.write_text(text)
    return path


def test_columns_are_scaled_offset_and_turned_into_si(tmp_path: Path) -> None:
    rig(tmp_path)
    (run,) = load_recordings(tmp_path)
    assert (run.name, run.session) == ("run", "monday")
    # Sample 5: 5 * 20000 us = 0.1 s; (5 * 2 - 90) deg = -80 deg; 5 / 8.
    assert run.channel("hip.position").time[5] == pytest.approx(0.1, rel=1e-12)
    assert run["hip.position"][5] == pytest.approx(math.radians(-80.0), rel=1e-12)
    assert run["knee.position"][5] == pytest.approx(0.625, rel=1e-12)
    assert run.channel("hip.command").hold


def test_a_binding_of_the_clock_alone_is_told_where_channels_go(tmp_path: Path) -> None:
    path, channel = rig(tmp_path, BINDING.split('"hip.position"')[0]), '"hip.position" = {'
    with pytest.raises(RecordingError, match="binds no channel") as caught:
        load_binding(path)
    assert "add to [columns] a line" in caught.value.fix
    # The line that the fix names, carried out.
    line = caught.value.fix[caught.value.fix.index(channel) :].replace("q1", "q")
    path.write_text(path.read_text() + line)
    assert list(load_binding(path).columns) == ["time", "hip.position"]


def test_the_root_given_by_the_caller_wins(tmp_path: Path) -> None:
    rig(tmp_path)
    moved = tmp_path / "moved.toml"
    moved.write_text(BINDING.replace('"logs"', '"/nowhere"'))
    assert load_recordings(moved, root=tmp_path / "logs")[0].samples == 12
    with pytest.raises(RecordingError, match="cannot be read"):
        load_recordings(moved)


def test_a_rate_stands_in_for_a_clock(tmp_path: Path) -> None:
    text = "rate_hz = 50.0\n" + BINDING.replace('time = { column = "stamp", unit = "us" }', "")
    (run,) = load_recordings(rig(tmp_path, text))
    # 12 samples at 50 Hz end 11 / 50 s after the first.
    assert run.seconds == pytest.approx(0.22, rel=1e-12)


@pytest.mark.parametrize(
    ("old", "new", "what", "line", "fix"),
    [
        ("session", "sesion", "the key 'sesion' is unknown", 5, "'session'"),
        ("offset", "ofset", "the key 'ofset' is unknown", 9, "'offset'"),
        ('root = "logs"', 'rout = "logs"', "the key 'rout' is unknown", 1, "'root'"),
        ('"deg"', '"degre"', "the unit 'degre' is unknown", 9, "'deg'"),
        ('unit = "deg", ', "", "the column has no unit", 9, 'unit = "rad"'),
        ('"deg"', '"V"', "the unit 'V' does not fit: .* in rad or m", 9, "correct the unit"),
        ("scale = 2.0", 'scale = "2"', "scale is '2'", 9, "a number"),
        ("scale = 2.0", "scale = nan", "scale is nan", 9, "a finite number"),
        ("scale = 2.0", "scale = 0", "scale is 0", 9, "correct it"),
        ("hip.position", "hip.positon", "'hip.positon' names no known quantity", 9, "'position'"),
        ('column = "q"', "column = 1.5", "column is 1.5", 9, "a number from 0"),
        ('"hip.command" = {', '"hip.command" = [', "not valid TOML", 11, "correct this line"),
        ('file = "run.csv"', "", "the episode has no file", 3, "add file"),
        ('time = { column = "stamp", unit = "us" }', "", "there is no clock", 7, "rate_hz"),
        (
            "[[episode]]",
            '[[episode]]\nfile = "run.csv"\n[[episode]]',
            "both called 'run'",
            5,
            "own",
        ),
        ('unit = "deg"', 'unit = "deg", frame = "body"', "frame is only for", 9, "remove it"),
        ('unit = "deg"', 'unit = "deg", form = "euler"', "form is only for", 9, "euler-xyz"),
        ('session = "monday"', 'command = "c.csv"', "command is 'c.csv', not a table", 5, "write"),
        (
            'session = "monday"',
            'command = { file = "c.csv", hold = "cubic" }',
            "hold is 'cubic'",
            5,
            "zero-order",
        ),
    ],
)
def test_a_wrong_binding_is_refused_at_its_line(
    tmp_path: Path, old: str, new: str, what: str, line: int, fix: str
) -> None:
    path = rig(tmp_path, BINDING.replace(old, new, 1))
    with pytest.raises(RecordingError, match=what) as caught:
        load_binding(path)
    assert caught.value.where == f"{path}:{line}"
    assert fix in caught.value.fix


@pytest.mark.parametrize(
    ("old", "new", "what", "fix"),
    [
        ('"q"', '"qq"', "there is no column 'qq'; the file has 4 columns: stamp, q", "'q'"),
        ("column = 2", "column = 7", "there is no column 7", "nearest"),
        ("element = 1, ", "", "each cell of column 2 holds 2 numbers", "element = 0 ... 1"),
        ("element = 1", "element = 2", "has no element 2: each cell holds 2", "count from 0"),
        ('file = "run.csv"', 'file = "run_2.csv"', "cannot be read", "root"),
    ],
)
def test_a_binding_that_does_not_fit_its_file_is_refused(
    tmp_path: Path, old: str, new: str, what: str, fix: str
) -> None:
    path = rig(tmp_path, BINDING.replace(old, new, 1))
    with pytest.raises(RecordingError, match=what) as caught:
        load_recordings(path)
    assert str(tmp_path / "logs") in caught.value.where
    assert fix in caught.value.fix


def test_commands_come_from_their_own_file_and_clock(tmp_path: Path) -> None:
    path = rig(
        tmp_path, BINDING.replace("[columns]", 'command = { file = "sent.csv" }\n\n[columns]')
    )
    sent = "\n".join(f"{50000 * at},{-at}" for at in range(12))
    (tmp_path / "logs" / "sent.csv").write_text(f"stamp,tau\n{sent}\n")
    (run,) = load_recordings(path)
    command = run.channel("hip.command")
    assert len(run.sources) == 2
    # At 0.12 s the command of 0.10 s, its third, still holds; it would be 6 in the first file.
    assert command.at(np.array([0.12])) == pytest.approx(-2.0)
    # Measurements end first, 11 * 0.02 s after they began.
    assert run.seconds == pytest.approx(0.22, rel=1e-12)


def test_commands_at_another_time_are_refused(tmp_path: Path) -> None:
    path = rig(
        tmp_path, BINDING.replace("[columns]", 'command = { file = "sent.csv" }\n\n[columns]')
    )
    sent = "\n".join(f"{9_000_000 + 50000 * at},{at}" for at in range(12))
    (tmp_path / "logs" / "sent.csv").write_text(f"stamp,tau\n{sent}\n")
    with pytest.raises(RecordingError, match="share no time") as caught:
        load_recordings(path)
    assert "sent.csv" in caught.value.where


def test_the_clock_of_commands_may_have_another_name_and_unit(tmp_path: Path) -> None:
    clock = 'command = { file = "sent.csv", time = { column = "ms", unit = "ms" } }\n\n[columns]'
    path = rig(tmp_path, BINDING.replace("[columns]", clock))
    sent = "\n".join(f"{50 * at},{-at}" for at in range(12))
    (tmp_path / "logs" / "sent.csv").write_text(f"ms,tau\n{sent}\n")
    (run,) = load_recordings(path)
    # Its third command, of 0.10 s.
    assert run.channel("hip.command").at(np.array([0.12])) == pytest.approx(-2.0)


def test_a_scale_may_be_a_ratio(tmp_path: Path) -> None:
    path = rig(tmp_path, BINDING.replace("scale = 2.0", 'scale = "-1/20"'))
    (run,) = load_recordings(path)
    assert run["hip.position"][5] == pytest.approx(math.radians(-90.25), rel=1e-12)
    for wrong in ('"1/0"', '"a/b"', '"1/2/3"', '"2"'):
        path.write_text(BINDING.replace("scale = 2.0", f"scale = {wrong}"))
        with pytest.raises(RecordingError, match="scale is") as caught:
            load_binding(path)
        assert '"1/33"' in caught.value.fix


@pytest.mark.parametrize(
    ("kind", "unit", "fits"),
    [
        ("motor", "N m", True),
        ("motor", "mNm", True),
        ("motor", "1", True),
        ("motor", "mA", False),
        ("motor", "deg", False),
        ("position", "deg", True),
        ("position", "N m", False),
    ],
)
def test_a_command_has_its_actuators_unit(tmp_path: Path, kind: str, unit: str, fits: bool) -> None:
    gains = ' kp="5"' if kind == "position" else ""
    description = f"""
<mujoco><worldbody><body><joint name="hip" axis="0 1 0"/><geom size="0.1"/>
 <body pos="0 0 1"><joint name="knee" axis="0 1 0"/><geom size="0.1"/></body></body></worldbody>
 <actuator><{kind} name="hip" joint="hip"{gains}/></actuator></mujoco>
"""
    (tmp_path / "leg.xml").write_text(description)
    path = rig(tmp_path, BINDING.replace('"tau", unit = "N m"', f'"tau", unit = "{unit}"'))
    robot = load(tmp_path / "leg.xml")
    if fits:
        assert len(load_recordings(path, robot=robot)) == 1
        return
    with pytest.raises(RecordingError, match="hip is commanded in") as caught:
        load_recordings(path, robot=robot)
    assert "recording.toml:11" in caught.value.where
