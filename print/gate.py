"""What stands before the slicer, since a slicer returns success on open, thin or huge parts too."""

from __future__ import annotations

from dataclasses import replace

from morph.print.check.checks import CHECKS, Rule
from morph.print.check.subject import Subject
from morph.print.errors import PrintError
from morph.print.part import Check, Part
from morph.print.printer import Profile
from morph.print.repair import MeshRepair, repaired


def check_part(part: Part, profile: Profile) -> tuple[Part, tuple[Check, ...]]:
    """Return a part, mended if it had to be and could be, and what was found.

    Nothing that a mesh can hold raises an error here: a part that cannot be printed has a check
    whose verdict is `refused`. What is not printed by itself passes unlooked at.

    Args:
        part: The part; of one that is bought or fused into another nothing is asked.
        profile: What it is to be printed on, and how.
    """
    if part.kind != "printed":
        return part, ()
    # What is mended is judged in millimetres, so the size is looked at first.
    size, *others = CHECKS
    sized = _look(size, Subject(part=part, profile=profile))
    if sized.verdict == "refused" or part.mesh is None:
        return part, (sized,)
    try:
        result = repaired(part.mesh, where=part.name)
    except PrintError as error:
        return part, (sized, _refused(part, "repair", error.what, error.fix))
    except FOREIGN as error:
        return part, (sized, _refused(part, "repair", f"it cannot be mended: {error}", ODD))
    mended = replace(part, mesh=result.mesh)
    repair = Check(
        part=part.name,
        name="repair",
        verdict="noted" if set(result.steps) - HARMLESS else "passed",
        what=_told(result),
        value=result.distance_mm,
    )
    checks = [sized, repair]
    subject = Subject(part=mended, profile=profile)
    for rule in others:
        checks.append(_look(rule, subject))
        if rule.first and checks[-1].verdict == "refused":
            break
    return mended, tuple(checks)


def _told(result: MeshRepair) -> str:
    """Return what was mended, and how far the part is now from what was given."""
    if not result.steps:
        return "nothing to mend"
    far = f"its surface moved by {result.distance_mm:.2g} mm at most"
    if result.volume_change is not None:
        far += f", its volume changed by {100 * result.volume_change:.2g} %"
    return f"{'; '.join(result.steps)}; {far}"


HARMLESS = frozenset({"merged coinciding corners"})
"""Steps that every STL needs."""
FOREIGN = (ValueError, RuntimeError, ArithmeticError, LookupError, TypeError, MemoryError)
"""What libraries raise on geometry that nobody foresaw."""
ODD = "mend the mesh in the CAD program and export it again"
"""What to do about such geometry."""


def _look(rule: Rule, subject: Subject) -> Check:
    try:
        return rule.look(subject)
    except PrintError as error:
        return _refused(subject.part, rule.name, error.what, error.fix)
    except FOREIGN as error:
        what = f"it cannot be looked at: {type(error).__name__}: {error}"
        return _refused(subject.part, rule.name, what, ODD)


def _refused(part: Part, name: str, what: str, fix: str) -> Check:
    return Check(part=part.name, name=name, verdict="refused", what=what, fix=fix)
