"""What a transfer along a chain found, in plain words."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from morph.app.report.align.words import VERDICTS
from morph.app.report.words import counted, percent
from morph.policy_transfer.hop_result import ENOUGH, Crossing
from morph.policy_transfer.relay_record import RelayRecord

NAMED: Mapping[str, str] = {
    "zero_shot": "the source's policy through the map",
    "final": "made anew with what the map tells",
    "no_source": "without a source",
    "scratch": "from scratch",
    "oracle": "the oracle",
    "hold_still": "holding still",
    "shuffled": "through a shuffled map",
    "flipped": "through a flipped map",
    "shuffled_anew": "made anew by a shuffled map",
    "flipped_anew": "made anew by a flipped map",
    "transfer": "transfer",
}
"""What each policy is called."""

CONTROLS = ("shuffled", "flipped", "shuffled_anew", "flipped_anew", "no_source")
"""What has the same transitions as the transfer."""

EQUAL = 0.01
"""Share of what the oracle gains by which a control may be worse or better and is as good."""

ORDER = tuple(NAMED)
"""The order in which they are shown."""


def chain_said(record: RelayRecord) -> str:
    """Return the names along the chain."""
    return " to ".join([record.hops[0].source, *(hop.target for hop in record.hops)])


def unsafe(record: RelayRecord) -> tuple[Crossing, ...]:
    """Return the hops that the guard calls unsafe."""
    return tuple(hop for hop in record.hops if hop.guard.verdict == "unsafe")


def done(record: RelayRecord) -> bool:
    """Return whether the last body does its task, and the guard calls no hop unsafe."""
    return record.hops[-1].good and not unsafe(record)


def headline(record: RelayRecord) -> str:
    """Return what came of it."""
    task, last = record.task.name, record.hops[-1]
    if unsafe(record):
        return f"The guard warns of {unsafe(record)[0].target}"
    if last.good:
        return f"{last.target} does {task}, by way of {counted(len(record.hops), 'hop', 'hops')}"
    return f"{last.target} does not do {task} as well as it could"


def summary(record: RelayRecord) -> tuple[str, ...]:
    """Return in a few sentences what was reached, what it took, and what it was worth."""
    last = record.hops[-1]
    final = last.scores["final"]
    given = "cannot be told from holding still" if final is None else f"has {share(final)}"
    lines = [
        f"On {last.target} the policy {given} of what the oracle gains over holding still. "
        f"It took {record.samples} transitions over {counted(len(record.hops), 'hop', 'hops')}."
        if final is not None
        else f"On {last.target} the oracle is no better than holding still: nothing was gained.",
    ]
    lines += [credit(hop) for hop in record.hops if credit(hop)]
    lines += [
        f"The guard calls the policy {hop.guard.verdict} on {hop.target}: "
        f"{VERDICTS[hop.guard.verdict]}."
        for hop in unsafe(record)
    ]
    return tuple(lines)


def share(value: float) -> str:
    """Return a share for running text."""
    return percent(value).replace("\N{NO-BREAK SPACE}", " ")


def credit(hop: Crossing) -> str:
    """Return what a hop's source was worth, by its controls; empty if there are none.

    What a control equals from the same transitions is no gain, and is called so.
    """
    ours = hop.scores["zero_shot" if hop.scores["final"] is None else "final"]
    if ours is None:
        return f"At {hop.target} there is no credit to give: holding still does as well."
    by = {name: _beyond(hop, name, ours) for name in CONTROLS if name in hop.measured}
    better = [NAMED[name] for name, more in by.items() if more > EQUAL]
    equal = [NAMED[name] for name, more in by.items() if -EQUAL <= more <= EQUAL]
    results = [
        f"{_listed(names)} {'is' if len(names) == 1 else 'are'} {how}"
        for names, how in ((better, "better"), (equal, "as good"))
        if names
    ]
    if not results:
        return ""
    return (
        f"At {hop.target} the source gains nothing with {hop.samples} transitions: "
        f"{'; '.join(results)}."
    )


def _listed(names: Sequence[str]) -> str:
    return " and ".join([", ".join(names[:-1]), names[-1]] if len(names) > 1 else names)


def _beyond(hop: Crossing, name: str, ours: float) -> float:
    """Return by how much a control is better than what is kept, over all draws if there are any."""
    means = {each.name: float(hop.relative(each.mean[-1])) for each in hop.curves}
    if "transfer" in means and name in means:
        return means[name] - means["transfer"]
    return float(hop.relative(hop.measured[name])) - ours


def saved(hop: Crossing) -> str:
    """Return what a hop saved in transitions, in a sentence; empty if no curve tells."""
    reached = hop.reached
    if "transfer" not in reached:
        return ""
    ours = reached["transfer"]
    good = f"{share(ENOUGH)} of what the oracle gains"
    if ours is None:
        return f"With the transitions that were given, transfer does not reach {good}."
    parts = [
        f"{NAMED[name]} {_took(hop, name, ours)}"
        for name in ("no_source", "scratch")
        if name in reached
    ]
    than = f"; {', '.join(parts)}" if parts else ""
    return f"Transfer reaches {good} after {ours} transitions{than}."


def _took(hop: Crossing, name: str, ours: int) -> str:
    theirs = hop.reached[name]
    if theirs is None:
        most = max(curve.samples[-1] for curve in hop.curves if curve.name == name)
        return f"had not after {most}"
    if theirs == ours:
        return "takes as many"
    return f"takes {theirs}, {abs(theirs - ours)} {'more' if theirs > ours else 'fewer'}"


def hop_said(number: int, hop: Crossing) -> str:
    """Return one line about a hop that has ended."""
    final, zero = hop.scores["final"], hop.scores["zero_shot"]
    given = "" if zero is None else f", through the map {zero:.2f}"
    given += "" if final is None else f", made anew {final:.2f}"
    return (
        f"hop {number}: {hop.source} to {hop.target}: {hop.samples} transitions{given}; "
        f"{hop.guard.verdict}"
    )
