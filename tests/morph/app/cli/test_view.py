from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import jsonschema
import pytest

from morph.app.cli import view
from morph.app.cli.main import main
from morph.app.viewer.state import BodyRequest, Saved, Sources
from morph.body.load import load

SCHEMA = json.loads(Path(view.__file__).with_name("viewing.schema.json").read_text())

Out = pytest.CaptureFixture[str]


@pytest.mark.parametrize(
    ("words", "what"),
    [
        ("", "there is nothing to show"),
        ("no_such_body", "no robot is called 'no_such_body'"),
        ("pendulum " * 9, "9 bodies are asked for, and the ground has room for 8"),
        ("no_such_body --seconds 0", "--seconds: it is 0 s"),
        ("no_such_body --seconds 1e9", "--seconds: it is 1e+09 s"),
        ("no_such_body --seconds nan", "--seconds: it is nan s"),
        ("no_such_body --port 70000", "--port: there is no port 70000"),
        ("no_such_body --seed -1", "--seed: it is -1"),
        ("no_such_body --html .", "--html .: it is a folder"),
        ("no_such_body --html /proc/none/page.html", "nothing can be written there"),
        ("no_such_body --state none.json", "--state none.json: cannot be read: No such file"),
        ("pendulum --first align", "there is no view 'align' of what was given"),
    ],
)
def test_what_cannot_be_shown_is_told_before_anything_is_loaded_or_served(
    words: str, what: str, capsys: Out
) -> None:
    assert main(["view", *words.split(), "--quiet"]) == 2
    told = capsys.readouterr()
    assert told.out == ""
    assert what in told.err
    assert "Traceback" not in told.err


def test_a_page_is_written_whole_and_told_in_json(tmp_path: Path, capsys: Out) -> None:
    page = tmp_path / "new" / "page.html"
    words = ["view", "pendulum", "--seconds", "1", "--quiet", "--json", "--html", str(page)]
    assert main(words) == 0
    told = json.loads(capsys.readouterr().out)
    jsonschema.validate(told, SCHEMA)
    assert told["html"] == str(page)
    assert told["bytes"] == page.stat().st_size
    assert [each.name for each in page.parent.iterdir()] == ["page.html"]
    assert "<code>morph view pendulum --seconds 1.0</code>" in page.read_text(encoding="utf-8")


def saved(tmp_path: Path, **more: object) -> Path:
    given = Sources(
        bodies=(BodyRequest(asked="pendulum", sha256=load("pendulum").sha256),), seconds=1.0
    )
    path = tmp_path / "view.json"
    kept = Saved(given=given, view="compare", **more)  # type: ignore[arg-type]
    path.write_text(kept.text(), encoding="utf-8")
    return path


def shows(words: list[str], tmp_path: Path) -> str:
    page = tmp_path / "page.html"
    assert main(["view", *words, "--html", str(page)]) == 0
    text = page.read_text(encoding="utf-8")
    return text[text.index('<section id="beside">') :]


def test_a_saved_view_shows_the_bodies_that_it_names(tmp_path: Path, capsys: Out) -> None:
    page = shows(["--state", str(saved(tmp_path))], tmp_path)
    assert "<li>pendulum" in page
    assert "has changed" not in page


def test_options_come_before_what_was_saved(tmp_path: Path, capsys: Out) -> None:
    page = shows(["cartpole", "--state", str(saved(tmp_path))], tmp_path)
    assert "<li>cartpole" in page
    assert "<li>pendulum" not in page


@pytest.mark.parametrize("seconds", [0.0, 120.1, 1e6])
def test_what_somebody_else_saved_lasts_no_longer_than_what_is_typed(
    tmp_path: Path, capsys: Out, seconds: float
) -> None:
    path = saved(tmp_path)
    whole = json.loads(path.read_text())
    whole["given"]["seconds"] = seconds
    path.write_text(json.dumps(whole))
    page = str(tmp_path / "page.html")
    assert main(["view", "--state", str(path), "--quiet", "--html", page]) == 2
    assert f"{path}, given.seconds: it is {seconds:g} s; more than 0" in capsys.readouterr().err
    # And what it tells to do helps.
    assert main(["view", "--state", str(path), "--quiet", "--html", page, "--seconds", "1"]) == 0


def test_a_body_that_has_changed_since_is_told(tmp_path: Path, capsys: Out) -> None:
    path = saved(tmp_path)
    path.write_text(path.read_text().replace(load("pendulum").sha256, "0" * 64))
    page = shows(["--state", str(path)], tmp_path)
    assert "pendulum has changed since this view was saved." in page
    assert "has changed" in capsys.readouterr().err


def test_the_files_that_a_saved_view_names_are_told(tmp_path: Path, capsys: Out) -> None:
    path = saved(tmp_path)
    whole = json.loads(path.read_text())
    whole["given"]["recordings"] = ["/etc/passwd", "../a\x1b[31m.csv"]
    path.write_text(json.dumps(whole))
    assert main(["view", "--state", str(path), "--quiet"]) == 2
    told = capsys.readouterr().err
    assert f"{path} names /etc/passwd\n" in told
    assert "\x1b" not in told


def test_a_state_of_a_view_that_does_not_fit_is_refused(tmp_path: Path, capsys: Out) -> None:
    path = saved(tmp_path, views={"compare": {"task": "fly"}})
    assert main(["view", "--state", str(path), "--quiet"]) == 2
    assert "fly" in capsys.readouterr().err


def test_a_browser_that_is_missing_is_told(monkeypatch: pytest.MonkeyPatch, capsys: Out) -> None:
    import webbrowser

    def none() -> None:
        raise webbrowser.Error("could not locate runnable browser")

    class Viewer:
        address = "http://localhost:1"

        def wait(self) -> None:
            pass

    monkeypatch.setattr(webbrowser, "get", none)
    monkeypatch.setattr(view, "served", lambda *given: Viewer())
    assert main(["view", "pendulum", "--browser", "--quiet"]) == 0
    assert "no browser was found; open the address by hand" in capsys.readouterr().err


def test_help_loads_nothing_heavy() -> None:
    code = (
        "import sys; from morph.app.cli.main import main\n"
        "try: main(['view', '--help'])\n"
        "except SystemExit: pass\n"
        "sys.stderr.write(' '.join({'viser', 'mujoco', 'jinja2', 'trimesh'} & set(sys.modules)))"
    )
    ran = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert "morph view cartpole" in ran.stdout
    assert ran.stderr == ""
