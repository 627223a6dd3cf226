"""How often the diagnosis is right: concealed cases, diagnosed, then opened.

Every case is made by `experiments.conceal` with dynamics that are not MuJoCo's, and
its truth is sealed. All are diagnosed first; only then are the seals opened.

Example: python -m experiments.concealed --effects 60 --clean 50 --seed 1
"""

from __future__ import annotations

import argparse
import json
import math
import sys
from collections.abc import Sequence
from pathlib import Path

from experiments.conceal import generate, make_cases, open_seal
from experiments.engine_options import add_engine_options, rows_of
from experiments.figures.save_options import parse_and_save
from morph.arrays import JSON
from morph.body.load import load as load_robot
from morph.body.robot import Robot
from morph.model.diagnose import FIT_HORIZON, MOST_SCREENED, MOST_SEGMENTS, diagnose
from morph.model.episodes import episode, step_for, stretches
from morph.model.hypothesis import Hypothesis
from morph.model.knobs import knobs
from morph.model.screen import screened, suspects
from morph.model.search import Search
from morph.model.segments import cut
from morph.record.binding import load_binding
from morph.record.load import load as load_recordings
from morph.record.recording import Recording
from morph.study.cell import Cell, cells_of


def diagnosed(case: str) -> JSON:
    """Return what the diagnosis says of the case in a folder, from its recordings alone."""
    folder = Path(case) / "recordings"
    robot = load_robot(str(load_binding(folder / "recording.toml").robot))
    recordings = load_recordings(folder, robot=robot)
    answer = diagnose(robot, recordings).as_json()
    return {**answer, "case": Path(case).name, "regression": regressed(robot, recordings)}


def regressed(robot: Robot, recordings: Sequence[Recording]) -> JSON:
    """Return the effect and place that explain most of the force missing from a description.

    The description's own figures are refitted as a diagnosis does; then one regression of the
    inverse dynamics on the same library of effects names the first. No effect is simulated, no
    second one is looked for, and since something always explains most, something is always named.

    Source: Swevers, Verdonck and De Schutter 2007, IEEE Control Systems Magazine 27(5), eq. 7.
    """
    step = step_for(recordings, robot)
    episodes = [episode(recording, robot, step) for recording in recordings]
    shortest = min(len(each.command) for each in episodes) * step
    search = Search(
        segments=cut(episodes, min(FIT_HORIZON, 0.5 * shortest), most=MOST_SEGMENTS),
        episodes=stretches(episodes, MOST_SCREENED),
        progress=lambda what, share: None,
        deadline=math.inf,
    )
    nominal = Hypothesis(robot=robot, step=step, knobs=knobs(robot))
    refitted = search.refit(nominal).fit
    first = suspects(screened(refitted.hypothesis, refitted.point, search.episodes))[0]
    name, _, place = first.effect.label.partition("@")
    return {"effect": name, "place": place, "gain": first.gain}


def cell_of(case: Path) -> Cell:
    """Return the cell of one case, known by its recordings; the truth is not among them."""
    recordings = sorted(path for path in (case / "recordings").rglob("*") if path.is_file())
    return cells_of(diagnosed, [{"case": str(case)}], data=recordings)[0]


def judged(answer: JSON, case: Path) -> JSON:
    """Return one row of the table: what was concealed, and what was named first."""
    sealed = open_seal(case)
    findings = answer["findings"]
    first = findings[0] if findings else None
    named = (first["effect"], first["where"]["name"]) if first else ("none", "")
    truth = (str(sealed.case.effect or "none"), str(sealed.case.place or ""))
    return {
        "case": case.name,
        "robot": answer["robot"],
        "truth": truth[0],
        "at": truth[1],
        "strength": float(sealed.strength or 0.0),
        "named": named[0],
        "named_at": named[1],
        "others": [f"{f['effect']}@{f['where']['name']}" for f in findings[1:]],
        "verdict": answer["verdict"],
        "right": named[0] == truth[0],
        "place": _joint(named[1]) == _joint(truth[1]),
        "rival": truth[0] in {r["effect"] for f in findings for r in f["rivals"]},
        "regression_named": answer["regression"]["effect"],
        "regression_right": answer["regression"]["effect"] == truth[0],
        "regression_place": _joint(answer["regression"]["place"]) == _joint(truth[1]),
        "seconds": answer["seconds"],
    }


def _joint(place: str) -> str:
    """Return the joint that a place belongs to: actuators are named as their joints."""
    return place.removesuffix(".position")


def main(arguments: list[str] | None = None) -> int:
    """Make the cases, diagnose them, open the seals, print the table."""
    parser = argparse.ArgumentParser(
        prog="python -m experiments.concealed",
        description=__doc__,
        formatter_class=argparse.RawTextHelpFormatter,
    )
    parser.add_argument("--effects", type=int, default=60, help="cases with one concealed effect")
    parser.add_argument("--clean", type=int, default=50, help="cases with none")
    parser.add_argument("--seed", type=int, default=1, help="of the cases")
    add_engine_options(parser, out="out/concealed")
    parser.add_argument("--json", action="store_true", help="print rows as JSON")
    asked, save = parse_and_save(parser, arguments, module="experiments.concealed")
    cases = []
    for count, clean in ((asked.effects, False), (asked.clean, True)):
        drawn = make_cases(count, asked.seed, clean=clean) if count else []
        folder = (
            asked.out.with_name(f"{asked.out.name}_cases")
            / f"seed_{asked.seed}_{'clean' if clean else 'effect'}_{count}"
        )
        if drawn and not (folder / "made").exists():
            sys.stderr.write(f"making {count} {'clean' if clean else 'concealed'} cases ...\n")
            generate(drawn, folder)
            (folder / "made").write_text("")
        cases += sorted(path for path in folder.glob("*") if path.is_dir()) if drawn else []
    answers = rows_of([cell_of(case) for case in cases], asked, name="concealed")
    rows = [judged(answer, case) for answer, case in zip(answers, cases, strict=True)]
    if save:
        save(**headline(rows), seeds=[asked.seed])
    report(rows, as_json=asked.json)
    return 0


def counted(rows: list[JSON]) -> JSON:
    """Return how often the diagnosis is right, and how often what knows nothing would be."""
    effects = [row for row in rows if row["truth"] != "none"]
    clean = [row for row in rows if row["truth"] == "none"]
    truths = [row["truth"] for row in effects]
    commonest = max(sorted(set(truths)), key=truths.count, default="none")
    return {
        "effects": len(effects),
        "named": sum(row["right"] for row in effects),
        "place": sum(row["place"] for row in effects),
        "named_or_rival": sum(row["right"] or row["rival"] for row in effects),
        "regression_named": sum(row["regression_right"] for row in effects),
        "regression_place": sum(row["regression_place"] for row in effects),
        "commonest": commonest,
        "always_commonest": truths.count(commonest),
        "shuffled": sum(
            row["named"] == truth
            for row, truth in zip(effects, [*truths[1:], *truths[:1]], strict=True)
        ),
        "clean": len(clean),
        "false_alarms": sum(row["named"] != "none" for row in clean),
        "regression_false_alarms": sum(row["regression_named"] != "none" for row in clean),
    }


def headline(rows: list[JSON]) -> JSON:
    """Return what a result file holds: shares of right names and places, and false alarms."""
    told = counted(rows)
    figures = dict(told)
    controls: JSON = {}
    if told["effects"]:
        share = 100.0 / told["effects"]
        figures |= {f"{key}_percent": share * told[key] for key in ("named", "place")}
        controls = {
            "linear regression names the first": {
                "named_percent": share * told["regression_named"],
                "place_percent": share * told["regression_place"],
            },
            "always the commonest answer": {"named_percent": share * told["always_commonest"]},
            "answers shuffled among the cases": {"named_percent": share * told["shuffled"]},
        }
        figures["commonest_percent"] = share * told["always_commonest"]
        figures["shuffled_percent"] = share * told["shuffled"]
    if told["clean"]:
        alarms = {"false_alarms": told["regression_false_alarms"]}
        controls["linear regression, which always names something"] = alarms
    return {"figures": figures, "controls": controls, "rows": rows}


def report(rows: list[JSON], *, as_json: bool) -> None:
    """Print every row, then the shares that the project promises."""
    if as_json:
        print(json.dumps(rows, indent=1))
        return
    for row in rows:
        mark = "ok " if row["right"] and row["place"] else ("law" if not row["right"] else "at ")
        print(
            f"{mark} {row['case']:18} {row['robot']:16} x{row['strength']:<5.1f} "
            f"{row['truth']}@{row['at']} -> {row['named']}@{row['named_at']} "
            f"{'+ ' + ', '.join(row['others']) if row['others'] else ''} ({row['seconds']:.0f} s)"
        )
    told = counted(rows)
    if many := told["effects"]:
        print(
            f"effect named first: {told['named']}/{many} = {told['named'] / many:.0%} (goal 75 %)"
        )
        print(f"place right: {told['place']}/{many} = {told['place'] / many:.0%} (goal 95 %)")
        print(f"effect named first or listed as a rival: {told['named_or_rival']}/{many}")
        print(
            f"rival, linear regression after a refit: named {told['regression_named']}/{many}, "
            f"place {told['regression_place']}/{many}; it never says that nothing is missing"
        )
        print(f"control, always saying {told['commonest']}: {told['always_commonest']}/{many}")
        print(f"control, answers shuffled among cases: {told['shuffled']}/{many}")
    if told["clean"]:
        print(f"clean cases with a finding: {told['false_alarms']}/{told['clean']} (goal 0)")


if __name__ == "__main__":
    sys.exit(main())
