"""`morph convert`: a clean description of a robot, in a folder of its own."""

from __future__ import annotations

import json
import sys

from morph.app.cli.arguments import Convert


def run_convert(asked: Convert) -> int:
    """Write the description and return the exit status."""
    from morph.body.convert import convert
    from morph.body.load import load

    robot = load(asked.robot, base=asked.base, folder=asked.folder)
    written = convert(robot, asked.to, asked.out)
    if asked.json:
        names = [str(path) for path in written.files]
        left_out = list(written.left_out)
        content = {"schema": "morph.conversion/1", "files": names, "left_out": left_out}
        sys.stdout.write(json.dumps(content, indent=2) + "\n")
        return 0
    sys.stdout.write(f"wrote {written.files[0]} and {len(written.files) - 1} files beside it\n")
    repaired = sum(finding.severity == "repaired" for finding in robot.findings)
    if repaired:
        sys.stdout.write(f"{repaired} repairs are in it; morph inspect {asked.robot} lists them\n")
    for left in written.left_out:
        sys.stdout.write(f"left out: {left}\n")
    return 0
