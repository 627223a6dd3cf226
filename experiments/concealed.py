"""How often the diagnosis is right: concealed cases, diagnosed, then opened.

Every case is made by `experiments.conceal` with dynamics that are not MuJoCo's, and
its truth is sealed. All are diagnosed first; only then are the seals opened.

Example: python -m experiments.concealed --effects 60 --clean 50 --seed 1
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from concurrent.futures import ProcessPoolExecutor, as_completed
from pathlib import Path
from typing import Any

from experiments.conceal import generate, make_cases, open_seal
from morph.files import sha256, write_whole


def diagnosed(case: Path) -> dict[str, Any]:
    """Return what the diagnosis says of one case, from its recordings alone."""
    from morph.body.load import load as load_robot
    from morph.model.diagnose import diagnose
    from morph.record.binding import load_binding
    from morph.record.load import load as load_recordings

    sources = sorted((Path(__file__).parent.parent / "morph").rglob("*.py"))
    kept = case / f"answer_{sha256(*sources)[:12]}.json"
    if kept.exists():
        found: dict[str, Any] = json.loads(kept.read_text())
        return found
    folder = case / "recordings"
    robot = load_robot(str(load_binding(folder / "recording.toml").robot))
    answer = diagnose(robot, load_recordings(folder, robot=robot)).as_json()
    answer["case"] = case.name
    write_whole(kept, json.dumps(answer))
    return answer


def judged(answer: dict[str, Any], case: Path) -> dict[str, Any]:
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
        "seconds": answer["seconds"],
    }


def _joint(place: str) -> str:
    """Return the joint that a place belongs to: actuators are named as their joints."""
    return place.removesuffix(".position")


def main() -> int:
    """Make the cases, diagnose them, open the seals, print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--effects", type=int, default=60, help="cases with one concealed effect")
    parser.add_argument("--clean", type=int, default=50, help="cases with none")
    parser.add_argument("--seed", type=int, default=1, help="of the cases")
    parser.add_argument("--jobs", type=int, default=2, help="cases diagnosed at once")
    parser.add_argument(
        "--out",
        type=Path,
        default=Path("out/concealed"),
        help="where cases are kept; finished ones are not done again",
    )
    parser.add_argument("--json", action="store_true", help="print rows as JSON")
    asked = parser.parse_args()
    cases = []
    for count, clean in ((asked.effects, False), (asked.clean, True)):
        drawn = make_cases(count, asked.seed, clean=clean) if count else []
        folder = asked.out / f"seed_{asked.seed}_{'clean' if clean else 'effect'}_{count}"
        if drawn and not (folder / "made").exists():
            sys.stderr.write(f"making {count} {'clean' if clean else 'concealed'} cases ...\n")
            generate(drawn, folder)
            (folder / "made").write_text("")
        cases += sorted(path for path in folder.glob("*") if path.is_dir()) if drawn else []
    began, answers = time.monotonic(), {}
    with ProcessPoolExecutor(asked.jobs) as pool:
        waiting = {pool.submit(diagnosed, case): case for case in cases}
        for done, future in enumerate(as_completed(waiting), 1):
            answers[waiting[future]] = future.result()
            sys.stderr.write(f"\r{done}/{len(cases)} diagnosed, {time.monotonic() - began:.0f} s ")
    sys.stderr.write("\n")
    rows = [judged(answers[case], case) for case in cases]
    report(rows, as_json=asked.json)
    return 0


def report(rows: list[dict[str, Any]], *, as_json: bool) -> None:
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
    effects = [row for row in rows if row["truth"] != "none"]
    clean = [row for row in rows if row["truth"] == "none"]
    if effects:
        right = sum(row["right"] for row in effects)
        place = sum(row["place"] for row in effects)
        rival = sum(row["right"] or row["rival"] for row in effects)
        always = max(
            sorted({row["truth"] for row in effects}),
            key=lambda t: sum(r["truth"] == t for r in effects),
        )
        base = sum(row["truth"] == always for row in effects)
        print(
            f"effect named first: {right}/{len(effects)} = {right / len(effects):.0%} (goal 75 %)"
        )
        print(f"place right: {place}/{len(effects)} = {place / len(effects):.0%} (goal 95 %)")
        print(f"effect named first or listed as a rival: {rival}/{len(effects)}")
        print(f"control, always saying {always}: {base}/{len(effects)} = {base / len(effects):.0%}")
        shuffled = sum(
            row["named"] == other["truth"]
            for row, other in zip(rows, [*effects[1:], effects[0]], strict=False)
        )
        print(f"control, answers shuffled among cases: {shuffled}/{len(effects)}")
    if clean:
        wrong = sum(row["named"] != "none" for row in clean)
        print(f"clean cases with a finding: {wrong}/{len(clean)} (goal 0)")


if __name__ == "__main__":
    sys.exit(main())
