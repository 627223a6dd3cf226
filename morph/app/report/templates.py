"""What renders the pages of reports."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import jinja2


@cache
def environment(*folders: Path) -> jinja2.Environment:
    """Return what renders the templates of these folders; every text is escaped.

    It is the same for the same folders: a template is compiled once in a process.
    """
    return jinja2.Environment(
        loader=jinja2.FileSystemLoader([*folders]),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
