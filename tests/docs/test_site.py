"""The site builds without a broken link."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def test_the_site_builds_with_every_page_and_asks_no_other_host(tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-m", "mkdocs", "build", "--quiet", "--site-dir", str(tmp_path / "site")],
        cwd=ROOT,
        env={**os.environ, "NO_MKDOCS_2_WARNING": "1"},
        capture_output=True,
        text=True,
        check=False,
    )
    # Strict: a broken link, an unknown anchor or a page that no menu names ends it.
    assert done.returncode == 0, done.stderr + done.stdout
    pages = {page.parent.name for page in (tmp_path / "site").rglob("index.html")}
    assert pages >= {path.stem for path in (ROOT / "docs").glob("*.md")} - {"index"}
    assert "Return" in (tmp_path / "site" / "api" / "index.html").read_text(encoding="utf-8")
    start = (tmp_path / "site" / "index.html").read_text(encoding="utf-8")
    asked = re.findall(r"<(?:script|link|img)[^>]+(?:src|href)=\"(https?:[^\"]+)\"", start)
    assert asked == []
