"""The report of a package: one page that needs no network and says the verdict in words first."""

from __future__ import annotations

import json
from collections.abc import Collection, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from jinja2.utils import htmlsafe_json_dumps
from markupsafe import Markup

from morph.app.report.align.page import style
from morph.app.report.page import _hash
from morph.app.report.print import words
from morph.app.report.print.solids import solids
from morph.app.report.print.steps import advised, plate_rows, steps
from morph.app.report.templates import environment
from morph.fabrication.content import Package

if TYPE_CHECKING:
    from morph.fabrication.margins import Margin


FOLDER = Path(__file__).parent


def print_page(
    package: Package, margins: Sequence[Margin] = (), sliced: Collection[str] = ()
) -> str:
    """Return the report as one HTML page.

    The page loads nothing, and its own policy forbids browsers to do so: only the scripts
    whose hashes it names may run. Names from files are escaped wherever they stand.

    Args:
        package: What is printed, and what became of it.
        margins: What each actuator needs and has.
        sliced: Names of the plates that have a G-code in the package.
    """
    drawn = solids(package)
    scripts = _scripts() if drawn else ()
    hashes = " ".join(f"'sha256-{_hash(script)}'" for script in scripts) or "'none'"
    checks = words.ordered(package.job.checks)
    return environment(FOLDER).get_template("page.html.j2").render(
        p=package,
        policy=f"default-src 'none'; style-src 'unsafe-inline'; img-src data: blob:; "
        f"script-src {hashes}; base-uri 'none'; form-action 'none'",
        style=Markup(style(FOLDER / "page.css")),
        headline=words.headline(package),
        failed=bool(words.refusals(package)) or not package.job.sliced
        or (package.policy is not None and package.policy.verdict == "lost"),
        summary=words.summary(package),
        steps=steps(package, sliced),
        plates=plate_rows(package, sliced),
        links=words.link_rows(package),
        parts=words.part_rows(package),
        margins=[words.margin_row(each) for each in margins],
        refused=[check for check in checks if check.verdict == "refused"],
        mended=advised(check for check in checks if check.verdict == "refused"),
        noted=[check for check in checks if check.verdict == "noted"],
        passed=[check for check in checks if check.verdict == "passed"],
        solids=htmlsafe_json_dumps(drawn, dumps=_dumps),
        scripts=[Markup(script) for script in scripts],
        provenance=_provenance(package),
    )  # fmt: skip


_dumps = partial(json.dumps, allow_nan=False, separators=(",", ":"))


def _scripts() -> tuple[str, str]:
    from plotly.offline import get_plotlyjs  # Only a page with solids waits for it.

    return get_plotlyjs(), (FOLDER / "page.js").read_text(encoding="utf-8")


def _provenance(package: Package) -> list[tuple[str, str]]:
    import morph

    slicers = {each.slicer for each in package.job.sliced.values() if each.slicer}
    return [
        ("morph", morph.__version__),
        ("slicer", ", ".join(sorted(slicers)) or "none"),
        ("the robot as designed", package.designed_sha256),
        ("the robot as printed", package.made_sha256),
    ]
