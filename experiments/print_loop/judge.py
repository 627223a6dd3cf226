"""What a diagnosis said of a printed robot, beside the truth."""

from __future__ import annotations

import numpy as np

from experiments.print_loop.bodies import commands
from experiments.print_loop.truth import COUNT, Truth, printed
from morph.arrays import JSON, Array
from morph.inference.diagnose import diagnose
from morph.model.finding import Finding
from morph.sim.simulator import Simulator

OF_LINKS = ("link_inertia", "com_offset", "payload")
"""Effects that say of a link that it weighs other than described."""
TRUSTED = {"mass": 0.0, "com": 0.0, "inertia": 0.0}
"""The description is taken at its word: whatever of a link is off is a finding."""


def judged(case: Truth) -> JSON:
    """Return the diagnosis of a case, judged."""
    found = diagnose(case.subject.robot, case.recordings, vary=TRUSTED)
    named = {f.effect.where for f in found.findings if f.effect.name in OF_LINKS}
    shown = showing(case)
    errors, inside = {}, []
    for finding in found.findings:
        change = case.changes.get(finding.effect.where)
        if finding.effect.name in OF_LINKS and change is not None:
            inside += _inside(case, finding)
            if finding.effect.name == "link_inertia":
                mass = finding.parameters["mass"].value - change.mass
                errors[finding.effect.where] = round(mass, 3)
    return {
        "right": len(named & shown),
        "shown": len(shown),
        "wrong": len(named - set(case.changes)),
        "other": [f.effect.label for f in found.findings if f.effect.name not in OF_LINKS],
        "named": [f.effect.label for f in found.findings],
        "mass_error": errors,
        "inside": inside,
        "verdict": found.verdict,
        "held_out_rmse": found.held_out_rmse,
        "seconds": found.seconds,
    }


def _inside(case: Truth, finding: Finding) -> list[bool]:
    """Return whether each true figure lies in the 90 % interval that was told."""
    change = case.changes[finding.effect.where]
    true = {"mass": change.mass, "inertia": change.inertia}
    if finding.effect.name == "com_offset":
        true = dict(zip("xyz", change.offset.tolist(), strict=True))
    told = finding.parameters
    return [
        bool(told[name].low90 <= value <= told[name].high90)
        for name, value in true.items()
        if name in told
    ]


def showing(case: Truth) -> set[str]:
    """Return the links whose change alone moves some reading by an encoder's count, rms."""
    rng = np.random.default_rng(0)
    told = commands(case.subject, rng)
    start = {name: 0.5 * half for name, half in case.subject.start.items()}

    def positions(links: set[str]) -> Array:
        changes = {link: case.changes[link] for link in links}
        run = Simulator(printed(case.subject.robot, changes), step=0.002).run(
            seconds=4.0, start=start, command=told
        )
        return np.stack([run[f"{j.name}.position"] for j in case.robot.joints])

    whole = positions(set())
    return {
        link
        for link in case.changes
        if np.sqrt(np.mean((positions({link}) - whole) ** 2, axis=1)).max() > COUNT
    }
