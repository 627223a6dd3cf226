"""Checks of recordings and settings before a diagnosis; every refusal is here."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from morph.body.follow import followers, leaders
from morph.body.robot import Robot
from morph.body.spec import spec_of
from morph.errors import DiagnosisError, RecordingError
from morph.model.episodes import Episode
from morph.record.noise import moves
from morph.record.recording import Channel, Recording

FARTHEST = 1e4
"""rad or m: positions beyond this are no robot's."""
STRONGEST = 1e6
"""Commands beyond this are no actuator's."""
SLOWEST = 0.2
"""Seconds between readings, of which one in a few tells of friction."""
HELD = 0.5
"""Mean acceleration of a free link less gravity, over gravity, from which something holds it."""
LONGEST_GAP = 60.0
"""Seconds without a reading after which a clock has jumped."""


def check_settings(horizon: float | None, budget: float | None, seed: int) -> None:
    """Refuse settings out of range.

    Raises:
        DiagnosisError: The horizon, the budget or the seed cannot be used.
    """
    if horizon is not None and not (math.isfinite(horizon) and horizon >= 0.1):
        raise DiagnosisError(
            f"a horizon of {horizon} s is out of range",
            where="--horizon",
            fix="give at least 0.1 s, or `full`",
        )
    if budget is not None and not budget > 0.0:
        raise DiagnosisError(
            f"the budget is {budget:g} s", where="--budget", fix="give seconds above zero"
        )
    if seed < 0:
        raise DiagnosisError(f"a seed of {seed} is below 0", where="--seed", fix="give 0 or more")


def check_recordings(train: Sequence[Recording], held_out: Sequence[Recording]) -> None:
    """Refuse recordings that are none, or that cannot be told apart by name.

    Raises:
        DiagnosisError: There is nothing to fit, or two recordings share a name.
    """
    if not train:
        raise DiagnosisError(
            "every recording is held out, none is left to fit"
            if held_out
            else "there is no recording to fit",
            where="the recordings",
            fix="give at least one recording of the robot in motion to fit",
        )
    names = [recording.name for recording in (*train, *held_out)]
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise DiagnosisError(
            f"several recordings are called {', '.join(twice)}",
            where="the recordings",
            fix="give each file once, and a held-out run of a folder by its name alone; else give "
            "each file or episode a name of its own",
        )


def check_tree(robot: Robot) -> None:
    """Refuse a robot whose joints constrain each other otherwise than in proportion.

    Raises:
        DiagnosisError: A closed chain is welded, or a joint is tied by another law, twice, by
            a ratio of zero, or to none that moves by itself.
    """
    weld = next(
        (loop.name or " and ".join(loop.links) for loop in robot.loops if loop.kind != "connect"),
        None,
    )
    if weld is not None:
        raise DiagnosisError(
            f"the closed chain {weld} is welded: forces on the joints of chains are modelled where "
            "they are pinned",
            where=f"robot {robot.name}",
            fix="close the chain by a pin (`connect`), or cut it; `morph compare` takes the robot "
            "as it is",
        )
    model = spec_of(robot).compile()
    direct, tied = followers(model)
    known = leaders(model)
    tied += [model.joint(each).name for each in direct if each not in known or not known[each][1]]
    if tied:
        raise DiagnosisError(
            f"joint {tied[0]} is tied otherwise than in proportion to one joint that moves by "
            "itself, and that is not diagnosed",
            where=f"robot {robot.name}",
            fix="let it follow one joint by a ratio other than 0, or weld it; `morph compare` "
            "takes the robot as it is",
        )


def check_channels(recording: Recording, robot: Robot, measured: Sequence[str]) -> None:
    """Refuse readings and commands that no robot gives, and clocks that jump.

    Raises:
        RecordingError: A channel is missing, or holds what cannot be.
    """
    for name in measured:
        if name not in recording.channels:
            raise RecordingError(
                f"there is no channel {name!r}; there are {', '.join(sorted(recording.channels))}",
                where=f"recording {recording.name}",
                fix="bind it in recording.toml. Positions of joints that no encoder read are "
                "estimated where another joint's is read, every command is recorded and no link "
                "moves freely, or come from poses of links; a free base is placed by its feet on a "
                "described floor and turned as a gyro and an accelerometer on it say; a joint that "
                "is held still can be welded in the description",
            )
        channel = recording.channels[name]
        _within(recording, name, channel, FARTHEST)
        gap = np.diff(channel.time)
        if len(gap) and np.median(gap) > SLOWEST:
            raise RecordingError(
                f"readings come {np.median(gap):.3g} s apart",
                where=f"recording {recording.name}, {name}",
                fix="if the clock is not in seconds, say so in a recording.toml that binds every "
                'column: [columns] with time = { column = "time", unit = "ms" } and a line such as '
                f'"{name}" = {{ column = "{name}", unit = "rad" }} for each of the others; else '
                f"record every {SLOWEST} s or faster",
            )
        if len(gap) and gap.max() > LONGEST_GAP:
            raise RecordingError(
                f"the clock jumps by {gap.max():.3g} s after sample {int(gap.argmax())}",
                where=f"recording {recording.name}, {name}",
                fix="cut the recording there and give the pieces as episodes",
            )
    for actuator in robot.actuators:
        name = f"{actuator.name}.command"
        if name not in recording.channels:
            raise RecordingError(
                f"there is no channel {name!r}; there are {', '.join(sorted(recording.channels))}",
                where=f"recording {recording.name}",
                fix="bind it in recording.toml, or of a motor the effort at its joint; for an "
                "actuator that was off, add a column of zeros, or take the actuator out of the "
                "description or its card",
            )
        _within(recording, name, recording.channel(name), STRONGEST)


def check_motion(recordings: Sequence[Recording], measured: Sequence[str]) -> tuple[str, ...]:
    """Return the joints that no recording moves beyond their sensors' noise.

    Args:
        recordings: Those to be fitted.
        measured: Channels of positions and orientations.

    Raises:
        DiagnosisError: Nothing moves at all.
    """
    read = [n for n in measured if any(each.channel(n).guess is None for each in recordings)]
    still = [
        name
        for name in read
        if not any(moves(each.channel(name).time, each[name]) for each in recordings)
    ]
    if len(still) == len(read):
        raise DiagnosisError(
            "nothing moves in any recording that is to be fitted",
            where=", ".join(recording.name for recording in recordings),
            fix="record the robot in motion, every joint at least some of the time",
        )
    joint = ".position"
    return tuple(name.removesuffix(joint) for name in still if name.endswith(joint))


def check_falls(episodes: Sequence[Episode], robot: Robot) -> None:
    """Refuse runs of a link that moves freely and is held by what no model here has.

    Raises:
        DiagnosisError: It does not fall, on average, as nothing but gravity would let it.
    """
    model = spec_of(robot).compile()
    gravity = np.asarray(model.opt.gravity, dtype=float)
    in_water = robot.card is not None and robot.card.water is not None
    if in_water or not gravity.any():
        return
    channels = episodes[0].measurement.channels
    for _, turn in episodes[0].measurement.coordinates.balls:
        place = slice(turn - 3, turn)
        link = channels[turn].removesuffix(".rotation.x")
        if channels[max(turn - 3, 0)] != f"{link}.position.x":
            continue  # A ball joint turns alone.
        root = model.body_rootid[model.body(link).id]
        tree = np.flatnonzero(model.body_rootid == root)
        # What floats as described weighs less.
        held = np.average(model.body_gravcomp[tree], weights=model.body_mass[tree])
        falls = np.mean(np.concatenate([each.acceleration[:, place] for each in episodes]), axis=0)
        if np.linalg.norm(falls - (1.0 - held) * gravity) > HELD * np.linalg.norm(gravity):
            raise DiagnosisError(
                f"link {link} does not fall as it would alone, and nothing is described there",
                where=", ".join(dict.fromkeys(each.name for each in episodes)),
                fix="describe the floor as a plane or name it by --world, a base that does not "
                "move as fixed, a robot in water with `gravcomp` or its `[water]` in the card; or "
                "give runs of free flight",
            )


def _within(recording: Recording, name: str, channel: Channel, most: float) -> None:
    if not np.isfinite(channel.value).all() or not np.isfinite(channel.time).all():
        raise RecordingError(
            "it holds NaN or infinity",
            where=f"recording {recording.name}, {name}",
            fix="read it with morph.load_recordings, which counts and drops single bad samples",
        )
    worst = int(np.argmax(np.abs(channel.value)))
    if abs(channel.value[worst]) > most:
        raise RecordingError(
            f"sample {worst} reads {channel.value[worst]:.3g}, beyond {most:g}",
            where=f"recording {recording.name}, {name}",
            fix="check the unit and the scale of this column",
        )
