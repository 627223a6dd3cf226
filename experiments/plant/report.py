"""The tables of the study of planted defects."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

from experiments.plant import DEFECTS
from morph.arrays import JSON

GOAL = 0.95
"""Share of the planted defects that is to be named."""


def report(result: JSON) -> None:
    """Print the rate of every class, every miss, what else was found, and the originals."""
    rows = result["rows"]
    print(f"{'class':18} {'named':>7} {'share':>6}  own code  via twin  robots")
    for name in dict.fromkeys(row["defect"] for row in rows):
        of = [row for row in rows if row["defect"] == name]
        named, own, twin = (sum(r[k] for r in of) for k in ("named", "by_own_code", "by_twin_only"))
        robots = len({row["robot"] for row in of})
        share = f"{named / len(of):.0%}"
        print(f"{name:18} {named:3}/{len(of):<3} {share:>6}  {own:8}  {twin:8}  {robots:6}")
    named = sum(row["named"] for row in rows)
    print(f"all: {named}/{len(rows)} = {named / max(1, len(rows)):.1%} (goal {GOAL:.0%})")
    _report_control(rows)
    for row in rows:
        if not row["named"]:
            _report_miss(row)
    _report_collateral(rows)
    _report_originals(result["originals"])
    print(f"{result['seconds']:.0f} s")


def wrong_classes(rows: Sequence[JSON]) -> list[tuple[str, str]]:
    """Return each class planted and another class whose codes the same copy raises anywhere."""
    codes = {row["defect"]: set(row["codes"]) for row in rows}
    for row in rows:
        codes[row["defect"]] |= set(row["codes"])
    return [
        (row["defect"], other)
        for row in rows
        for other in codes
        if other != row["defect"]
        and not codes[other] & codes[row["defect"]]
        and codes[other] & {f["code"] for f in row["beside"] + row["elsewhere"]}
    ]


def _report_control(rows: Sequence[JSON]) -> None:
    """Print how often a class's codes are raised at all among the plants of other classes."""
    hits = wrong_classes(rows)
    print(f"control: a class named, anywhere, in a copy that holds another: {len(hits)}")
    for (planted_class, other), count in sorted(Counter(hits).items()):
        print(f"  {count:3} x {other} in copies with {planted_class}")


def _report_miss(row: JSON) -> None:
    said = [f"{f['code']}@{f['where']['name']}" for f in row["beside"] + row["elsewhere"]]
    print(f"missed: {row['defect']} ({row['variant']}) at {row['robot']}/{row['site']}")
    print(f"    {row['did']}; {row['fact']}")
    print(f"    verdict {row['verdict']}; new: {', '.join(said[:8]) or 'nothing'}")
    if row["known_before"]:
        print(f"    already in the original: {', '.join(row['known_before'])}")


def _report_collateral(rows: Sequence[JSON]) -> None:
    for kind, words in (("beside", "at the place, other codes"), ("elsewhere", "elsewhere")):
        count = Counter((row["defect"], f["code"]) for row in rows for f in row[kind])
        print(f"also new, {words}: {sum(count.values())}")
        for (name, code), times in sorted(count.items()):
            robots = sorted(
                {
                    r["robot"]
                    for r in rows
                    if r["defect"] == name and code in {f["code"] for f in r[kind]}
                }
            )
            print(f"  {times:4} x {code:18} with {name:18} in {', '.join(robots)}")


def _report_originals(before: dict[str, JSON]) -> None:
    findings = [
        (name, f, fact)
        for name, of in before.items()
        for f, fact in zip(of["findings"], of["measured"], strict=True)
    ]
    rewritten = sum(len(of["new_when_rewritten"]) for of in before.values())
    print(f"control: new in originals that were only written anew: {rewritten}")
    print(f"originals: {len(before)} descriptions, {len(findings)} findings by code")
    for code, times in sorted(Counter(f["code"] for _, f, _ in findings).items()):
        print(f"  {times:4} x {code}")
    planted_codes = set().union(*(d.codes(v) | d.also(v) for d in DEFECTS for v in d.variants))
    print("originals: findings with a code of the fifteen classes, to be verified")
    for name, finding, fact in findings:
        if finding["code"] in planted_codes:
            where = finding["where"]
            print(f"  {name:16} {finding['code']:18} {where['kind']} {where['name']}")
            print(f"      said: {finding['what']}")
            print(f"      measured: {fact}")
