from __future__ import annotations

import json
import subprocess
import sys

import pytest

from morph.app.cli.main import main
from morph.search.searches import DEFAULTS, SEARCHES, search
from morph.task.tasks import TASKS


def test_a_list_of_searches_says_what_their_classes_say(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert main(["list", "searches", "--json"]) == 0
    rows = json.loads(capsys.readouterr().out)["searches"]
    assert [row["name"] for row in rows] == list(SEARCHES)
    for row in rows:
        kind = search(row["name"])
        first = (kind.__doc__ or "").splitlines()[0]
        assert row["what"].lower()[1:] == first.removeprefix("Return ").lower()[1:]
        assert row["needs"] == ("trials on the target" if kind.from_trials else "a simulator")


def test_a_list_of_searches_waits_for_no_torch() -> None:
    script = (
        "import sys; from morph.app.cli.main import main; "
        "main(['list', 'searches']); sys.exit('torch' in sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, check=False)
    assert done.returncode == 0, done.stderr


def test_every_task_has_a_default_that_there_is() -> None:
    assert set(DEFAULTS) <= set(TASKS)
    assert set(DEFAULTS.values()) <= set(SEARCHES)
