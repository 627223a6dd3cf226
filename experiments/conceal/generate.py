"""Cases made into files: recordings to diagnose, and beside them the sealed truth."""

from __future__ import annotations

import gzip
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from experiments.conceal.batch import EPISODES, Batch, prepare
from experiments.conceal.case import Case, make_cases
from experiments.conceal.draw import Sizes, parameters
from experiments.conceal.march import Motion
from experiments.conceal.mechanisms import MECHANISMS
from experiments.conceal.seal import Sealed, write_seal
from experiments.conceal.sensor import noise_rms, quanta, read
from morph.files import write_whole

TOGETHER = 40
"""Most cases simulated at once, which bounds the memory to less than 1 GB."""


def conceal(case: Case | int, folder: Path) -> Sealed:
    """Make one case in a folder: `recordings/` and, beside it, `sealed/`.

    Args:
        case: A case, or a seed from which one with an effect is drawn.
        folder: Where to write.
    """
    chosen = make_cases(1, case, clean=False)[0] if isinstance(case, int) else case
    return next(_made([chosen], [folder]))


def generate(cases: list[Case], folder: Path) -> list[Sealed]:
    """Make many cases, each in a folder of its name; cases of one robot run together."""
    made: dict[str, Sealed] = {}
    for robot in MECHANISMS:
        same = [case for case in cases if case.robot == robot]
        for begin in range(0, len(same), TOGETHER):
            group = same[begin : begin + TOGETHER]
            for sealed in _made(group, [folder / case.name for case in group]):
                made[sealed.case.name] = sealed
    return [made[case.name] for case in cases]


def _made(cases: list[Case], folders: list[Path]) -> Iterator[Sealed]:
    batch, sizes = prepare(cases).settled()
    motion, strengths = batch.run(sizes)
    for number, folder in enumerate(folders):
        _write_recordings(batch, number, sizes[number], motion, folder / "recordings")
        sealed = _truth(batch, number, sizes[number], float(strengths[number]))
        write_seal(sealed, folder)
        yield sealed


def _truth(batch: Batch, number: int, sizes: Sizes, strength: float) -> Sealed:
    equations, case = batch.equations, batch.cases[number]
    noise = noise_rms(quanta(equations, sizes.counts))
    driven = [(i, j) for i, j in enumerate(equations.joints) if j in equations.actuators]
    return Sealed(
        case=case,
        parameters=parameters(case, sizes),
        strength=float(f"{strength if case.effect else 0.0:.4g}"),
        true={name: float(value[number]) for name, value in batch.true.items()},
        nominal=equations.nominal(),
        gains={name: float(batch.gains[i, number]) for i, name in driven},
        noise={f"{j}.position": float(noise[i]) for i, j in enumerate(equations.joints)},
        rate_hz=batch.rates[number],
    )


def _write_recordings(
    batch: Batch, number: int, sizes: Sizes, motion: Motion, folder: Path
) -> None:
    equations, case, rng = batch.equations, batch.cases[number], batch.rngs[number]
    quantum = quanta(equations, sizes.counts)
    driven = [i for i, joint in enumerate(equations.joints) if joint in equations.actuators]
    header = ["time", *(f"{joint}.position" for joint in equations.joints)]
    header += [f"{equations.joints[i]}.command" for i in driven]
    bias = parameters(case, sizes).get("bias", 0.0)
    binding = [f'robot = "{case.robot}"']
    for index in range(EPISODES):
        row = EPISODES * number + index
        episode = batch.episodes[row]
        columns = [episode.ticks]
        for joint in range(len(equations.joints)):
            position = motion.position(row, joint, episode.ticks)
            if joint == case.joint:
                position = position + bias
            columns.append(read(position, float(quantum[joint]), rng))
        columns += [episode.commands[i] for i in driven]
        name = f"episode_{index + 1}"
        write_whole(folder / f"{name}.csv.gz", _csv(header, np.array(columns).T))
        session = "first" if index < 3 else "second"
        binding += ["", "[[episode]]", f'file = "{name}.csv.gz"', f'name = "{name}"']
        binding += [f'session = "{session}"']
    units = dict(zip(equations.joints, equations.kinds, strict=True))
    binding += ["", "[columns]", *(_column(name, units) for name in header)]
    write_whole(folder / "recording.toml", "\n".join(binding) + "\n")


def _column(channel: str, kinds: dict[str, str]) -> str:
    joint, _, quantity = channel.partition(".")
    turning = kinds.get(joint) == "hinge"
    unit = {"": "s", "position": "rad" if turning else "m", "command": "N m" if turning else "N"}
    return f'"{channel}" = {{ column = "{channel}", unit = "{unit[quantity]}" }}'


def _csv(header: list[str], table: np.ndarray) -> bytes:
    form = ",".join(["%.6f", *["%.8f"] * (table.shape[1] - 1)])
    lines = [",".join(header), *(form % tuple(row) for row in table.tolist()), ""]
    return gzip.compress("\n".join(lines).encode(), compresslevel=6, mtime=0)
