"""`python -m experiments.conceal`: make cases, or open the seal of one."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from experiments.conceal import Sealed, generate, make_cases, open_seal
from morph.errors import MorphError

EXAMPLE = """example:
  python -m experiments.conceal --count 3 --seed 7 --out /tmp/cases
  morph diagnose cartpole /tmp/cases/effect_7_000/recordings/recording.toml --out /tmp/diagnosis
  python -m experiments.conceal --open /tmp/cases/effect_7_000
"""


def main(arguments: list[str] | None = None) -> int:
    """Run the command and return its exit status."""
    parser = argparse.ArgumentParser(
        prog="python -m experiments.conceal",
        description="Make recordings whose truth is sealed beside them.",
        epilog=EXAMPLE,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--count", type=int, default=1, help="how many cases (default 1)")
    parser.add_argument("--seed", type=int, default=0, help="fixes all that is drawn (default 0)")
    parser.add_argument("--clean", action="store_true", help="hide no effect, only wrong masses")
    choice = parser.add_mutually_exclusive_group(required=True)
    choice.add_argument("--out", type=Path, metavar="DIR", help="folder for the cases")
    choice.add_argument("--open", type=Path, metavar="CASE", help="print the truth of a case")
    chosen = parser.parse_args(arguments)
    try:
        if chosen.open is not None:
            print(in_words(open_seal(chosen.open)))
            return 0
        cases = make_cases(chosen.count, chosen.seed, clean=chosen.clean)
        for sealed in generate(cases, chosen.out):
            print(f"{chosen.out / sealed.case.name}: {sealed.case.robot}, truth sealed")
    except MorphError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    return 0


def in_words(sealed: Sealed) -> str:
    """Return the truth of a case in one sentence."""
    case = sealed.case
    if case.effect is None:
        return f"{case.robot}: nothing was left out"
    sizes = ", ".join(f"{name} = {value:g}" for name, value in sealed.parameters.items())
    return (
        f"{case.robot}: {case.effect} at {case.kind} {case.place} ({sizes}), "
        f"{sealed.strength:.1f} times the noise"
    )


if __name__ == "__main__":
    sys.exit(main())
