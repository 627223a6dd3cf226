"""Published descriptions, counted: what became of them, beside MuJoCo alone and Pinocchio."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass

from experiments.corpus_repairs import AGREE
from morph.arrays import JSON


@dataclass(frozen=True, kw_only=True)
class Row:
    """One description."""

    file: str
    """Its path below the set's folder."""
    verdict: str
    """`ok`, `repaired`, `refused`, or `crash`."""
    codes: tuple[tuple[str, str], ...]
    """Code and severity of each finding."""
    why: str
    """Of a refusal or a crash: the first reason."""
    seconds: float
    """Time of one inspection, with Pinocchio's second opinion."""
    mass: float | None
    """kg, as MuJoCo steps it."""
    stated: float | None
    """kg, the sum of the masses in the text, counted apart from morph's reader."""
    named: int
    """Links whose mass differs from the text's as a finding at that very link says."""
    silent: str
    """Links whose mass differs and of which no finding says so."""
    uncounted: str
    """Why the masses of the text were not counted; empty if they were."""
    differs: float | None
    """Greatest relative difference to Pinocchio's reading; None if Pinocchio cannot read it."""
    explained: bool
    """Whether a difference is gone once the named repairs are made in the file too."""
    explained_by: str
    """Codes of the repairs whose undoing brings the difference back."""
    mujoco: str
    """What MuJoCo does with the file as it is: `loads`, `loses mass` or `fails`."""
    bare: str
    """The same without the file's shapes, so that no missing mesh is in its way."""


def lost(rows: Iterable[Row]) -> list[Row]:
    """Return the descriptions with a link whose mass differs from the text's in silence.

    None is exempt: one that loads and whose masses could not be counted is among them.
    """
    return [row for row in rows if row.silent or row.uncounted]


def summary(rows: Sequence[Row]) -> str:
    """Return the table."""
    count = len(rows)
    verdicts = Counter(row.verdict for row in rows)
    lines = [f"{count} descriptions"]
    lines += [f"  {verdicts[name]:5d} {name}" for name in ("ok", "repaired", "refused", "crash")]
    for title, alone in (
        ("with the files as they are", Counter(row.mujoco for row in rows)),
        ("without their shapes", Counter(row.bare for row in rows)),
    ):
        shares = (
            f"{alone[name]} {name} ({alone[name] / max(count, 1):.0%})"
            for name in ("loads", "loses mass", "fails")
        )
        lines.append(f"MuJoCo alone, {title}: {', '.join(shares)}")
    silent, loaded = lost(rows), [row for row in rows if row.mass is not None]
    changed = [row for row in loaded if row.named]
    lines.append(
        f"masses of {len(loaded)} that load compared link by link, none exempt: mass lost or "
        f"gained in silence: {len(silent)}; in {len(changed)} a finding at the link states the "
        f"mass that it was given ({sum(row.named for row in changed)} links)"
    )
    lines += [f"        {row.file}: {row.silent or row.uncounted}" for row in silent]
    read = [row for row in rows if row.differs is not None]
    agree = sum(row.differs is not None and row.differs <= AGREE for row in read)
    explained = [row for row in read if row.explained]
    left = [row for row in read if (row.differs or 0.0) > AGREE and not row.explained]
    lines.append(
        f"Pinocchio reads {len(read)} of those that load: {agree} agree to {AGREE:g}, "
        f"{len(explained)} agree once the named repairs are made in the file too and differ again "
        f"once they are undone, {len(left)} differ by more"
    )
    by = Counter(row.explained_by for row in explained)
    lines += [f"        {number:5d} by {codes}" for codes, number in by.most_common()]
    lines += [f"        {row.file}: differs by {row.differs:.2g}" for row in left]
    apart = [row.file for row in rows if any(code == "agreement" for code, _ in row.codes)]
    lines.append(
        f"of the rest, and of what is repaired, it reads what MuJoCo is given: "
        f"{len(rows) - verdicts['refused'] - len(read)} files that it cannot read itself, "
        f"{len(apart)} findings of agreement"
    )
    lines.append("findings (descriptions with it, in all):")
    per_code = Counter(key for row in rows for key in set(row.codes))
    total = Counter(key for row in rows for key in row.codes)
    for (code, severity), number in sorted(per_code.items()):
        lines.append(f"  {number:5d} {total[code, severity]:6d}  {code} ({severity})")
    seconds = sorted(row.seconds for row in rows)
    lines.append(
        f"seconds a description: middle {seconds[len(seconds) // 2]:.2f}, most {seconds[-1]:.2f}"
    )
    for row in rows:
        if row.verdict in ("refused", "crash"):
            lines.append(f"{row.verdict}: {row.file}\n    {row.why}")
    return "\n".join(lines)


def headline(rows: Sequence[Row]) -> JSON:
    """Return what a result file holds: verdicts, lost mass, and Pinocchio's judgement."""
    verdicts = Counter(row.verdict for row in rows)
    read = [row for row in rows if row.differs is not None]
    agree = sum(row.differs is not None and row.differs <= AGREE for row in read)
    explained = sum(
        row.differs is not None and row.differs > AGREE and row.explained for row in read
    )
    figures = {
        "descriptions": len(rows),
        "ok": verdicts["ok"],
        "repaired": verdicts["repaired"],
        "loaded": verdicts["ok"] + verdicts["repaired"],
        "refused": verdicts["refused"],
        "crashed": verdicts["crash"],
        "mass_lost": len(lost(rows)),
        "mass_checked": sum(row.stated is not None for row in rows),
        "mass_uncounted": sum(bool(row.uncounted) for row in rows),
        "mass_named": sum(row.named > 0 for row in rows),
        "mass_named_links": sum(row.named for row in rows),
        "read_by_pinocchio": len(read),
        "agree": agree,
        "explained": explained,
        "agree_or_explained": agree + explained,
        "unexplained": len(read) - agree - explained,
        "mujoco_whole": sum(row.mujoco == "loads" for row in rows),
    }
    controls = {
        title: {word: sum(said == word for said in told) for word in set(told)}
        for title, told in (
            ("MuJoCo alone", [row.mujoco for row in rows]),
            ("MuJoCo alone, without shapes", [row.bare for row in rows]),
        )
    }
    kept = ("file", "verdict", "mass", "stated", "named", "silent", "uncounted", "differs")
    judged = ("explained", "explained_by", "mujoco", "bare")
    return {
        "figures": figures,
        "controls": controls,
        "rows": [{key: asdict(row)[key] for key in (*kept, *judged)} for row in rows],
    }
