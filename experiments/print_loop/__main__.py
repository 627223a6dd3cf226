"""Does a diagnosis say of a printed robot which links weigh other than designed?

Bodies are changed as printing at 15 % infill changes them, recorded with the noise of an encoder
of 12 bits and torques off by up to 3 %, and diagnosed against their descriptions. Controls: one
link alone is off, nothing is, and dry friction is left out instead. Seeds 0 to 9 judge; it was
built on seeds from 100 on.
"""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path

import numpy as np

from experiments.figures.save_options import parse_and_save
from experiments.print_loop.bodies import BODIES, subject
from experiments.print_loop.judge import judged
from experiments.print_loop.truth import KINDS, truth
from morph.arrays import JSON
from morph.errors import MorphError
from morph.files import write_whole

EXAMPLE = """example:
  python -m experiments.print_loop --bodies so101 --kinds all --seeds 100
  python -m experiments.print_loop --package out/package --bodies so101 --seeds 0
"""


def main(arguments: list[str] | None = None) -> int:
    """Run the study and return its exit status."""
    parser = argparse.ArgumentParser(
        prog="python -m experiments.print_loop",
        description=__doc__,
        epilog=EXAMPLE,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--bodies", nargs="+", choices=BODIES, default=BODIES)
    parser.add_argument("--kinds", nargs="+", choices=KINDS, default=KINDS)
    parser.add_argument("--seeds", nargs="+", type=int, default=[0])
    parser.add_argument(
        "--package", type=Path, help="folder that `morph print` wrote: its robot is the true one"
    )
    parser.add_argument("--out", type=Path, help="file for the rows, as JSON")
    asked, save = parse_and_save(parser, arguments, module="experiments.print_loop.__main__")
    rows = []
    try:
        for name in asked.bodies:
            body = subject(name)
            for kind in asked.kinds:
                for seed in asked.seeds:
                    row = judged(truth(body, kind, seed, package=asked.package))
                    rows.append({"body": name, "kind": kind, "seed": seed, **row})
                    print(said(rows[-1]), flush=True)
                    if asked.out:
                        write_whole(asked.out, json.dumps(rows, indent=1))
    except MorphError as error:
        sys.stderr.write(f"error: {error}\n")
        return 2
    except KeyboardInterrupt:
        return 130
    if save:
        save(**headline(rows), seeds=asked.seeds)
    for name in asked.bodies:
        for kind in asked.kinds:
            print(summary(name, kind, [r for r in rows if (r["body"], r["kind"]) == (name, kind)]))
    return 0


def headline(rows: list[JSON]) -> JSON:
    """Return what a result file holds: links named, missed and accused, by body and kind."""
    figures: JSON = {}
    controls: JSON = {}
    for name, kind in dict.fromkeys((row["body"], row["kind"]) for row in rows):
        mine = [row for row in rows if (row["body"], row["kind"]) == (name, kind)]
        errors = [abs(error) for row in mine for error in row["mass_error"].values()]
        told = {
            "named": sum(row["right"] for row in mine),
            "that_show": sum(row["shown"] for row in mine),
            "wrong": sum(row["wrong"] for row in mine),
            "other_effects": sum(len(row["other"]) for row in mine),
        }
        if errors:
            told["mass_off"] = max(errors)
        if kind in ("none", "friction"):
            controls[f"{name}_{kind}"] = told
        figures |= {f"{name}_{kind}_{key}": value for key, value in told.items()}
    kept = [{key: row[key] for key in row if key != "held_out_rmse"} for row in rows]
    return {"figures": figures, "controls": controls, "rows": kept}


def said(row: JSON) -> str:
    """Return one case in a line."""
    return (
        f"{row['body']:16} {row['kind']:9} {row['seed']:3}  right {row['right']} of "
        f"{row['shown']} that show, wrong {row['wrong']}, other {row['other']}; mass off by "
        f"{row['mass_error']}; {row['seconds']:.0f} s; {' '.join(row['named']) or 'none'}"
    )


def summary(name: str, kind: str, rows: list[JSON]) -> str:
    """Return the figures of one body and kind."""
    right, shown = sum(r["right"] for r in rows), sum(r["shown"] for r in rows)
    errors = [abs(error) for r in rows for error in r["mass_error"].values()]
    inside = [each for r in rows for each in r["inside"]]
    return (
        f"{name} {kind}: links named {right} of {shown} that show; wrong links "
        f"{sum(r['wrong'] for r in rows)}; other effects {sum(len(r['other']) for r in rows)}; "
        f"mass factor off by {np.median(errors) if errors else float('nan'):.3f} at the median, "
        f"parameters within their intervals {sum(inside)} of {len(inside)}; "
        f"{np.median([r['seconds'] for r in rows]):.0f} s"
    )


if __name__ == "__main__":
    sys.exit(main())
