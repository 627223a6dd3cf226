"""What is checked in every description; one file for each kind of fault."""

from __future__ import annotations

from morph.body.check.fit import check_fit
from morph.body.check.lengths import check_lengths
from morph.body.check.limits import check_limits
from morph.body.check.mass import check_mass
from morph.body.check.meshes import check_meshes
from morph.body.check.mimic import check_mimic
from morph.body.check.symmetry import check_symmetry
from morph.body.check.tree import check_tree
from morph.body.draft import Draft
from morph.body.finding import DescriptionFinding
from morph.body.paths import Files
from morph.body.shapes import read_shapes

REPAIRS = (check_meshes, check_limits, check_mimic)
"""Checks that may give back a mended draft, in this order, once it is one tree."""

LOOKS = (check_lengths, check_fit, check_symmetry)
"""Checks that only look."""


def check(
    draft: Draft, files: Files, *, base_moves: bool = False
) -> tuple[Draft, list[DescriptionFinding]]:
    """Return a draft that can be simulated, and everything found in it.

    If a finding is of severity `refused`, the draft cannot be simulated.
    """
    draft, findings = check_tree(draft)
    if any(finding.severity == "refused" for finding in findings):
        return draft, findings
    draft, result = read_shapes(draft, files)
    findings += result
    for repair in REPAIRS:
        draft, result = repair(draft)
        findings += result
    # What masses there were is looked at before missing ones are made up.
    for look in LOOKS:
        findings += look(draft)
    draft, result = check_mass(draft, base_moves=base_moves)
    return draft, findings + result
