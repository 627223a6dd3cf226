"""Hooks of mkdocs: pages that lie beside `docs`, notebooks as pages, and links between them."""

from __future__ import annotations

import json
import posixpath
import re
from pathlib import Path
from typing import Any

from mkdocs.structure.files import File, Files

ROOT = Path(__file__).resolve().parents[1]
PLACES = {"docs/": "", "experiments/": "studies/"}
"""Where the pages of a folder of the repository stand in the site."""
LINK = re.compile(r"\[([^\]]*)\]\((?!https?:|mailto:|#)([^)#\s]+)(#[^)\s]*)?\)")
"""A link to a file: its text, path and anchor."""


def on_files(files: Files, config: Any) -> Files:
    """Return the files of the site, with the studies' pages and the notebooks as pages."""
    experiments = ROOT / "experiments"
    # What was fetched is no page of ours.
    for page in set(experiments.rglob("*.md")) - set((experiments / "data").rglob("*.md")):
        place = _place(page.relative_to(ROOT).as_posix()) or ""
        files.append(File.generated(config, place, abs_src_path=str(page)))
    for notebook in (ROOT / "docs").rglob("*.ipynb"):
        name = notebook.relative_to(ROOT).as_posix()
        if (copied := files.get_file_from_path(name.removeprefix("docs/"))) is not None:
            files.remove(copied)
        content = as_markdown(json.loads(notebook.read_text(encoding="utf-8")))
        files.append(File.generated(config, _place(name) or "", content=content))
    return files


def on_page_markdown(markdown: str, page: Any, config: Any, files: Files) -> str:
    """Return a page whose links lead into the site; what the site lacks is named, not linked."""
    source = page.file.src_uri
    beside = source.startswith("studies/")
    folder = posixpath.dirname(
        source.replace("studies/", "experiments/", 1) if beside else f"docs/{source}"
    )

    def linked(match: re.Match[str]) -> str:
        text, path, anchor = match.group(1), match.group(2), match.group(3) or ""
        place = _place(posixpath.normpath(posixpath.join(folder, path)))
        if place is None:
            return text
        return f"[{text}]({posixpath.relpath(place, posixpath.dirname(source) or '.')}{anchor})"

    return LINK.sub(linked, markdown)


def as_markdown(notebook: Any) -> str:
    """Return a notebook as a page: its texts, and its code in fences."""
    parts = []
    for cell in notebook["cells"]:
        text = "".join(cell["source"]).rstrip()
        parts.append(text if cell["cell_type"] == "markdown" else f"```python\n{text}\n```")
    return "\n\n".join(parts) + "\n"


def _place(path: str) -> str | None:
    """Return where a file of the repository stands in the site; None if it does not."""
    for folder, place in PLACES.items():
        inside = path.startswith(folder) and (place == "" or path.endswith(".md"))
        if inside:
            path = place + path.removeprefix(folder)
            return path.removesuffix(".ipynb") + ".md" if path.endswith(".ipynb") else path
    return None
