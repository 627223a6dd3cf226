from __future__ import annotations

import io
import itertools
import zipfile
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from morph.app.viewer.content import Actor, LiveCell, Marked
from morph.app.viewer.printed.choices import APART, COLOURINGS, PLATES, STEPS, PrintChoices
from morph.app.viewer.printed.figures import how_far, part_of, when
from morph.app.viewer.printed.package_content import notes, tables
from morph.app.viewer.printed.package_zip import zipped
from morph.app.viewer.printed.viewed_package import HELD, ViewedPackage
from morph.errors import OutputError
from morph.print.part import Check

EVIL = "<script>alert(1)</script>"


def boxes(actor: Actor, picture: int) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """The upright box of each copy, m."""
    found = {}
    for shape in actor.figure.shapes:
        corners = shape.vertices + actor.motion.position[picture, shape.body]
        found[actor.figure.links[shape.body]] = corners.min(axis=0), corners.max(axis=0)
    return found


def test_the_body_comes_apart_by_as_much_as_was_planned(made: ViewedPackage) -> None:
    (actor,), moments = made.actors(PrintChoices())
    assert [moment.title for moment in moments] == ["together", "apart"]
    first, last = (actor.motion.at(moment.time) for moment in moments)
    gone = actor.motion.position[last] - actor.motion.position[first]
    for at, link in enumerate(actor.figure.links[1:], 1):
        copy = int(link.partition(" ")[2] or 1) - 1
        planned = 1e-3 * made.told.offsets[part_of(link), copy]
        np.testing.assert_allclose(gone[at], planned, atol=1e-12)


def test_step_by_step_all_is_in_its_place_at_the_end_and_the_base_first(
    made: ViewedPackage,
) -> None:
    (apart,), _ = made.actors(PrintChoices())
    (actor,), moments = made.actors(PrintChoices(show=STEPS))
    np.testing.assert_allclose(actor.motion.position[-1], apart.motion.position[0], atol=1e-12)
    assert moments[0].title == "body"
    assert len(moments) == len(made.told.links)
    assert all(a.time < b.time for a, b in itertools.pairwise(moments))


def test_what_is_on_a_plate_stands_on_its_bed_and_within_it(made: ViewedPackage) -> None:
    name = made.job.plates[0].name
    (actor,), _ = made.actors(PrintChoices(show=name))
    found = boxes(actor, 0)
    bed = found.pop("bed")
    assert len(found) == len(made.job.plates[0].laid)
    for low, high in found.values():
        # Shapes are thinned for the browser and then move by less than a tenth of a millimetre.
        assert low[2] == pytest.approx(bed[1][2], abs=1e-4)
        assert (low[:2] > bed[0][:2]).all()
        assert (high[:2] < bed[1][:2]).all()


def test_every_plate_is_one_body_each(made: ViewedPackage) -> None:
    both = replace(made.job, plates=(made.job.plates[0], replace(made.job.plates[0], name="two")))
    two = ViewedPackage(made.robot, replace(made.package, job=both))
    assert two.ways == (APART, STEPS, PLATES, made.job.plates[0].name, "two")
    assert len(two.actors(PrintChoices(show=PLATES))[0]) == 2


@pytest.mark.parametrize("by", COLOURINGS)
def test_a_colouring_colours_every_copy_of_a_part_alike(made: ViewedPackage, by: str) -> None:
    made.paint(by)
    assert made.has(by)
    (actor,), _ = made.actors(PrintChoices(by=by))
    seen: dict[str, list[bytes]] = {}
    for shape in actor.figure.shapes:
        told = np.array(shape.colour) if shape.colours is None else shape.colours
        assert shape.colours is None or shape.colours.shape == shape.vertices.shape
        seen.setdefault(part_of(actor.figure.links[shape.body]), []).append(told.tobytes())
    assert {len(set(each)) for each in seen.values()} == {1}


def test_a_part_that_is_pointed_at_is_seen_and_told(made: ViewedPackage) -> None:
    made.paint("overhang")
    (actor,), _ = made.actors(PrintChoices(part="lower_leg", by="overhang"))
    held = {shape.body for shape in actor.figure.shapes if shape.colour == HELD}
    assert {part_of(actor.figure.links[body]) for body in held} == {"lower_leg"}
    table = tables(made, PrintChoices(part="lower_leg"))[0]
    # What the scale showed comes before what was estimated.
    assert ("mass", "7.0 g") in table.rows


def test_the_slider_and_the_clock_mean_the_same() -> None:
    for percent in (0, 1, 25, 50, 99, 100):
        # The table that is looked up has 200 steps; between them a line differs from the curve
        # by at most 6 / 8 / 200^2 = 2e-5.
        assert how_far(when(0.01 * percent)) == pytest.approx(0.01 * percent, abs=1e-4)


def test_checks_stand_with_the_refused_first_and_the_passed_counted(made: ViewedPackage) -> None:
    checks = (
        Check(part="a", name="wall", verdict="passed", what="thick"),
        Check(part="b", name="wall", verdict="noted", what="thin in places", fix="look"),
        Check(part=EVIL, name="bed fit", verdict="refused", what=EVIL, fix="cut it"),
    )
    looked = ViewedPackage(made.robot, replace(made.package, job=replace(made.job, checks=checks)))
    (table,) = (each for each in tables(looked, PrintChoices()) if each.title == "Checks")
    verdicts = [row[0].text for row in table.rows if isinstance(row[0], Marked)]
    assert verdicts == ["refused", "noted", "passed"]
    assert table.rows[0][1] == f"{EVIL}, bed fit: {EVIL}. Put it right: cut it."
    assert table.rows[2][1] == "wall 1"


def test_masses_of_links_stand_beside_each_other(made: ViewedPackage) -> None:
    (table,) = (each for each in tables(made, PrintChoices()) if each.title.startswith("Mass"))
    assert len(table.rows) == len(made.package.links)
    assert not any(isinstance(cell, LiveCell) for row in table.rows for cell in row)
    total = sum(float(str(row[1])) for row in table.rows)
    # Nine links, each rounded to 0.05 g.
    assert total == pytest.approx(1e3 * made.package.designed_kg, abs=0.45)


def test_what_is_not_written_says_how_to_write_it(made: ViewedPackage) -> None:
    assert any("`morph print` makes the package" in note for note in notes(made))
    written = ViewedPackage(made.robot, replace(made.package, folder=Path("/somewhere/walker")))
    assert any(note == "The package is the folder walker." for note in notes(written))


def test_a_zip_holds_the_files_of_the_folder_and_nothing_that_links_lead_to(
    tmp_path: Path,
) -> None:
    folder, secret = tmp_path / "package", tmp_path / "secret"
    (folder / "plates").mkdir(parents=True)
    (folder / "package.json").write_text("{}")
    (folder / "plates" / "one.3mf").write_bytes(b"x" * 1000)
    secret.mkdir()
    (secret / "key").write_text("mine")
    (folder / "key").symlink_to(secret / "key")
    (folder / "away").symlink_to(secret)
    with zipfile.ZipFile(io.BytesIO(zipped(folder, "walker"))) as found:
        assert sorted(found.namelist()) == ["walker/package.json", "walker/plates/one.3mf"]


def test_a_package_that_is_too_large_is_not_sent(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("morph.app.viewer.printed.package_zip.MOST_BYTES", 10)
    (tmp_path / "file").write_bytes(b"x" * 11)
    with pytest.raises(OutputError, match="copy the folder by hand"):
        zipped(tmp_path, "walker")
