"""How often a planted defect is named at the right link, and what is found without one.

Fifteen classes of defects are planted in copies of descriptions that others published, a
defect a copy, each where measured facts make it one. The importer inspects every copy, and
the untouched original. Named is a defect if a finding with a code of its class stands at its
place, and the original has no such finding.
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from experiments.figures.save_options import parse_and_save
from experiments.needs import need_packaged, need_robots
from experiments.plant import DEFECTS
from experiments.plant.defect import Planted
from experiments.plant.description import Description
from experiments.plant.draw import Chosen, draw, planted
from experiments.plant.facts import measured
from experiments.plant.originals import PACKAGED, PUBLISHED, originals
from experiments.plant.report import report, wrong_classes
from morph.arrays import JSON
from morph.errors import MorphError
from morph.files import write_whole

EXAMPLE = """example:
  python -m experiments.planted --seed 1
  python -m experiments.planted --defect unit-swap --per-class 24 --json --out out/planted.json
  python -m experiments.planted --dry
"""
Said = list[dict[str, Any]]
"""Findings as JSON holds them."""


def inspected(path: Path) -> tuple[Said, str]:
    """Return the importer's findings about one description, and its verdict."""
    from morph.body.inspect import inspect_robot

    try:
        found = inspect_robot(path)
    except Exception as error:  # The importer promises never to raise: that is a result too.
        return [], f"crash: {error!r}"
    return [finding.as_json() for finding in found.findings], str(found.verdict)


def key(finding: dict[str, Any]) -> tuple[str, str, str]:
    """Return what makes two findings the same: code, kind of place, name of place."""
    return finding["code"], finding["where"]["kind"], finding["where"]["name"]


def judged(plant: Planted, before: Said, after: Said, verdict: str) -> JSON:
    """Return one row: what was planted, whether it was named, and what else is new."""
    known = {key(finding) for finding in before}
    new = [finding for finding in after if key(finding) not in known]
    right: Said = []
    also: Said = []
    beside: Said = []
    elsewhere: Said = []
    for finding in new:
        where = finding["where"]
        here = plant.places.hold(where["kind"], where["name"], finding["what"])
        own, near = finding["code"] in plant.codes, finding["code"] in plant.also
        (
            right if here and own else also if here and near else beside if here else elsewhere
        ).append(finding)
    return {
        **{k: v for k, v in asdict(plant).items() if k not in ("places", "codes", "also")},
        "codes": sorted(plant.codes),
        "verdict": verdict,
        "named": bool(right or also),
        "by_own_code": bool(right),
        "by_twin_only": bool(right or also)
        and all(f["where"]["name"] in plant.places.partners for f in right + also),
        "known_before": sorted(
            {f["code"] for f in before if f["code"] in plant.codes and _at(plant, f)}
        ),
        "found": right + also,
        "beside": beside,
        "elsewhere": elsewhere,
    }


def _at(plant: Planted, finding: dict[str, Any]) -> bool:
    where = finding["where"]
    return plant.places.hold(where["kind"], where["name"], finding["what"])


def untouched(used: Sequence[Description], folder: Path) -> dict[str, JSON]:
    """Return what is found in each original, and what is new once it is only written anew."""
    found = {}
    for original in used:
        copy = original.copy_to(folder / original.name)
        began = time.monotonic()
        before, verdict = inspected(copy.path)
        seconds = time.monotonic() - began
        copy.write(copy.parse())
        again, _ = inspected(copy.path)
        known = {key(finding) for finding in before}
        found[original.name] = {
            "verdict": verdict,
            "seconds": seconds,
            "findings": before,
            "measured": [
                measured(original, f["where"]["kind"], f["where"]["name"]) for f in before
            ],
            "new_when_rewritten": [f for f in again if key(f) not in known],
        }
    return found


def studied(chosen: Sequence[Chosen], seed: int, said: Callable[[str], None]) -> JSON:
    """Plant every defect that was chosen, inspect each copy, and return all rows."""
    used = {one.original.name: one.original for one in chosen}
    rows = []
    with tempfile.TemporaryDirectory(prefix="planted_") as name:
        said(f"inspecting {len(used)} originals")
        before = untouched([used[robot] for robot in sorted(used)], Path(name))
        for place, one in enumerate(chosen):
            said(f"{place + 1}/{len(chosen)} {one.defect.name} in {one.original.name}")
            with tempfile.TemporaryDirectory(prefix="copy_", dir=name) as folder:
                rng = np.random.default_rng([seed, 1000 + place])
                copy, plant = planted(one, Path(folder), rng)
                after, verdict = inspected(copy.path)
            rows.append(judged(plant, before[plant.robot]["findings"], after, verdict))
    return {"seed": seed, "rows": rows, "originals": before}


def chosen_places(
    names: Sequence[str], count: int, seed: int, descriptions: Sequence[Description]
) -> list[Chosen]:
    """Return where the defects go, class by class; each class has its own stream of chance."""
    return [
        place
        for number, defect in enumerate(DEFECTS)
        if defect.name in names
        for place in draw(defect, descriptions, count, np.random.default_rng([seed, number]))
    ]


def headline(result: JSON) -> JSON:
    """Return what a result file holds: how many defects are named, and what else is."""
    rows, kept = result["rows"], ("defect", "variant", "robot", "site", "verdict", "named")
    figures = {
        "planted": len(rows),
        "named": sum(row["named"] for row in rows),
        "named_percent": 100.0 * sum(row["named"] for row in rows) / len(rows),
        "by_own_code": sum(row["by_own_code"] for row in rows),
        "classes": len({row["defect"] for row in rows}),
        "originals": len(result["originals"]),
    }
    rewritten = sum(len(of["new_when_rewritten"]) for of in result["originals"].values())
    controls = {
        "originals written anew": {"new_findings": rewritten},
        "a class named in a copy that holds another": {"copies": len(wrong_classes(rows))},
    }
    return {
        "figures": figures,
        "controls": controls,
        "rows": [{key: row[key] for key in kept} for row in rows],
        "seeds": [result["seed"]],
    }


def main(arguments: list[str] | None = None) -> int:
    """Run the study and return its exit status."""
    parser = argparse.ArgumentParser(
        prog="python -m experiments.planted",
        description=__doc__,
        epilog=EXAMPLE,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    names = [defect.name for defect in DEFECTS]
    parser.add_argument("--seed", type=int, default=1, help="1 for building, 2 held out")
    parser.add_argument("--per-class", type=int, default=12, help="plants of each class")
    parser.add_argument("--defect", choices=names, action="append", help="only this class")
    parser.add_argument("--dry", action="store_true", help="say where they go, inspect nothing")
    parser.add_argument("--json", action="store_true", help="print JSON instead of tables")
    parser.add_argument("--out", type=Path, help="also write the JSON into this file")
    parser.add_argument("--quiet", action="store_true", help="show no progress")
    asked, save = parse_and_save(parser, arguments, module="experiments.planted")
    try:
        # Fewer originals would be another study.
        need_robots(*(folder.split("/")[0] for folder, _ in PUBLISHED.values()))
        need_packaged(*(f"{folder}/{urdf}" for folder, urdf in PACKAGED.values()))
    except MorphError as error:
        sys.stderr.write(f"error: {error}\n")
        return 2
    descriptions, began = originals(), time.monotonic()
    chosen = chosen_places(asked.defect or names, asked.per_class, asked.seed, descriptions)
    if asked.dry:
        for one in chosen:
            print(
                f"{one.defect.name:18} {one.variant:14} {one.original.name}/{one.site}: {one.fact}"
            )
        return 0

    def said(words: str) -> None:
        if not asked.quiet:
            sys.stderr.write(f"[{time.monotonic() - began:5.1f} s] {words}\n")

    try:
        result = studied(chosen, asked.seed, said)
    except KeyboardInterrupt:
        return 130
    result["seconds"] = time.monotonic() - began
    if save:
        save(**headline(result))
    if asked.out:
        write_whole(asked.out, json.dumps(result, indent=1))
    if asked.json:
        print(json.dumps(result, indent=1))
    else:
        report(result)
    return 0


if __name__ == "__main__":
    sys.exit(main())
