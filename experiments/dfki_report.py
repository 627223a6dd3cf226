"""The study of the double pendulum in words and tables, and as a result file holds it."""

from __future__ import annotations

from collections.abc import Mapping

from experiments.figures.result_file import figure_name
from experiments.openloop import in_row, span
from morph.arrays import JSON


def report(name: str, result: JSON) -> None:
    """Print one design's findings and its table of errors."""
    found = result["diagnosis"]
    print(f"\ndesign {name}: {found['verdict']}, {found['seconds']:.0f} s")
    print(f"  fitted {', '.join(result['train'])}; held out {', '.join(result['held_out'])}")
    for finding in found["findings"]:
        figures = ", ".join(
            f"{symbol} {e['value']:.3g} [{e['low90']:.3g}, {e['high90']:.3g}] {e['unit']}"
            for symbol, e in finding["parameters"].items()
        )
        print(
            f"  found {finding['effect']} at {finding['where']['name']}: {figures}, "
            f"probability {finding['probability']:.2f}"
        )
        rivals = ", ".join(
            f"{r['effect']} at {r['where']['name']} ({r['probability']:.2f})"
            for r in finding["rivals"]
        )
        print(f"    rivals: {rivals or 'none'}")
    factors, levels = result["published"]["coulomb_factor"], result["published"]["level"]
    print(
        "  published friction: cf arctan(100 v) with cf "
        + ", ".join(f"{each:.3f}" for each in factors)
        + " N m, which is a level of "
        + ", ".join(f"{each:.3f}" for each in levels)
    )
    for title, told in result["sysid"].items():
        values = ", ".join(f"{key} {value:.3g}" for key, value in told["values"].items())
        print(f"  {title}: {told['seconds']:.1f} s; {values}")
    for score in result["scores"]:
        where = f"{', '.join(score['runs'])}; {span(score['horizon_s'])}"
        print(f"  RMSE, rad, over {where}:")
        joints = next(iter(score["rmse"].values()))
        print(f"  {'':34} " + "  ".join(f"{joint:>8}" for joint in joints))
        for model, by_joint in score["rmse"].items():
            times = score["times_corrected"][model].values()
            print(in_row(model, by_joint, "   " + ", ".join(f"x{each:.1f}" for each in times)))
        if score is result["scores"][0] and result["goal"]:
            print(in_row("goal", dict(zip(joints, result["goal"], strict=True))))


def headline(results: Mapping[str, JSON]) -> JSON:
    """Return what a result file holds of the designs: held-out errors, rad, and findings."""
    figures: JSON = {}
    controls: JSON = {}
    rows = []
    for name, result in results.items():
        label = f"{name.replace('.', '').lower()}_" if len(results) > 1 else ""
        found = result["diagnosis"]
        figures[f"{label}verdict"] = found["verdict"]
        figures[f"{label}found"] = ", ".join(
            f"{each['effect']} at {each['where']['name']}" for each in found["findings"]
        )
        for model, errors_of in result["scores"][0]["rmse"].items():
            if model.startswith("control: "):
                controls[f"{label}{model.removeprefix('control: ')}"] = errors_of
            else:
                own = label + figure_name(model)
                figures |= {f"{own}_{joint}": error for joint, error in errors_of.items()}
        rows += [{"design": name, **score} for score in result["scores"]]
        rows += [
            {"design": name, **{key: each[key] for key in ("effect", "where", "parameters")}}
            for each in found["findings"]
        ]
    return {"figures": figures, "controls": controls, "rows": rows}
