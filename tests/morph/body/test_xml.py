"""XML from strangers: what is hostile is refused by its line, soon, and in little memory."""

from __future__ import annotations

import codecs
import json
import random
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from morph.body.xml import DEEPEST, MOST_BYTES, MOST_ELEMENTS, parse
from morph.errors import RobotError

MOST = 4 * 2**20
"""Bytes of a hostile file: as many as are read at all."""

CANARY = "canary.dtd"
"""A file beside the description, which nobody may open for an entity's sake."""


def fill(start: str, filler: str, end: str) -> str:
    return start + filler * ((MOST - len(start) - len(end)) // len(filler)) + end


def many(pattern: str, count: int) -> str:
    return "".join(pattern.format(number) for number in range(count))


def in_joint(start: str, filler: str, end: str) -> str:
    return fill(f'{ROBOT}<joint name="j" {start}', filler, f"{end}</joint></robot>")


ROBOT = '<robot name="r"><link name="a"/>'
SHAPE = '<collision><geometry><sphere radius="1"/></geometry></collision>'
LAUGHS = many('<!ENTITY a{} "ha">', 1) + "".join(
    f'<!ENTITY a{n} "{f"&a{n - 1};" * 10}">' for n in range(1, 10)
)


def refused() -> dict[str, str | bytes]:
    """Return files of which no robot may come; together they are too long to be kept."""
    return {
        "a million nested elements": "<robot>" + "<a>" * 10**6,
        "a million elements": "<robot>" + "<a/>" * 10**6 + "</robot>",
        "a billion laughs": f'<!DOCTYPE r [{LAUGHS}]><robot name="&a9;"/>',
        "a long entity": f'<!DOCTYPE r [<!ENTITY a "{"a" * 10**6}">]><robot>{"&a;" * 9**5}</robot>',
        "a parameter entity": f'<!DOCTYPE r [<!ENTITY % a SYSTEM "{CANARY}"> %a;]><robot/>',
        "an external entity": f'<!DOCTYPE r [<!ENTITY a SYSTEM "{CANARY}">]><robot name="&a;"/>',
        "an external DTD": f'<!DOCTYPE r SYSTEM "{CANARY}"><robot/>',
        "a public DTD": f'<!DOCTYPE r PUBLIC "a" "{CANARY}"><robot/>',
        "default attributes": "<!DOCTYPE r [<!ATTLIST r "
        + many('a{} CDATA "x" ', 200_000)
        + ">]><robot/>",
        "a long default": f'<!DOCTYPE r [<!ATTLIST a b CDATA "{"x" * 10**6}">]>'
        f"<robot>{'<a/>' * 40_000}</robot>",
        "a deep content model": f"<!DOCTYPE r [<!ELEMENT a {'(' * 10**6}>]><robot/>",
        "notations": fill("<!DOCTYPE r [", '<!NOTATION a SYSTEM "b">', "]><robot/>"),
        "attributes": "<robot " + many(' a{}="x"', 300_000) + "/>",
        "attributes everywhere": "<robot>"
        + ("<a " + many('b{}="x" ', 90) + "/>") * 4500
        + "</robot>",
        "a long tag": fill("<robot><", "a", "/></robot>"),
        "a long name": fill('<robot name="', "a", '"><link name="a"/></robot>'),
        "long text": fill("<robot>", "a", "</robot>"),
        "texts": fill("<robot>", "a<!---->", "</robot>"),
        "comments": fill("<robot>", "<!---->", "</robot>"),
        "character references": fill("<robot>", "&#97;", "</robot>"),
        "line ends": fill("<robot>", "\n", "</robot>"),
        "a long number": in_joint('type="fixed"><origin xyz="', "1", '"/>'),
        "many numbers": in_joint('type="fixed"><origin xyz="', "1 ", '"/>'),
        "a long type": in_joint('type="', "fixed", '">'),
        "a long parent": in_joint('type="fixed"><parent link="', "a", '"/>'),
        "links": "<robot>" + many('<link name="{}"/>', 40_000) + "</robot>",
        "joints": ROBOT + many('<joint name="{}" type="fixed"/>', 40_000) + "</robot>",
        "joints of one name": ROBOT + '<joint name="j" type="fixed"/>' * 1000 + "</robot>",
        "loose links": "<robot>" + many('<link name="{}"/>', 1000) + "</robot>",
        "shapes": f'<robot><link name="a">{SHAPE * 12_000}</link></robot>',
        "rubbish": random.Random(1).randbytes(MOST),
        "zeros": bytes(MOST),
        "rubbish that starts well": b"<robot>" + random.Random(2).randbytes(10**6),
        "too many bytes": "<robot>" + " " * MOST + "</robot>",
    }


def loaded() -> dict[str, str]:
    """Return files that hold a robot, with too much of something that is left out."""
    return {
        "misspelt elements": ROBOT + "<lnk/>" * 40_000 + "</robot>",
        "foreign elements": ROBOT + many("<k{}jqvxyzwabcdefgh/>", 40_000) + "</robot>",
        "a long path": fill(
            '<robot><link name="a"><visual><geometry><mesh filename="',
            "a/",
            '"/></geometry></visual></link></robot>',
        ),
    }


READ = """
import json, pathlib, sys, time
import morph.body.build, morph.body.check, morph.body.urdf_robot
from morph.body.description import read_description
from morph.errors import DescriptionRefused

results = {}
for path in sorted(pathlib.Path(sys.argv[1]).glob("*.urdf")):
    start = time.process_time()
    try:
        said, findings = "loaded", read_description(path).findings
    except DescriptionRefused as error:
        said, findings = str(error), error.findings
    length = len(said) + sum(len(finding.what) + len(finding.fix) for finding in findings)
    results[path.stem] = (time.process_time() - start, said[:400], length)
# The peak of getrusage is no less than that of the process that started this one.
status = pathlib.Path("/proc/self/status").read_text()
peak = next(line for line in status.splitlines() if line.startswith("VmHWM:"))
print(json.dumps((results, int(peak.split()[1]))))
"""
"""Reads each in a process of its own; prints the seconds, what was said, how long, and the kB."""


@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="needs Linux to tell memory")
def test_what_is_hostile_is_refused_within_a_second_and_200_mb(
    tmp_path: Path, slowness: Callable[[], float]
) -> None:
    (tmp_path / CANARY).write_text('<!ENTITY a "the canary sang">')
    hostile = refused()
    for name, content in {**hostile, **loaded()}.items():
        written = content if isinstance(content, bytes) else content.encode()
        (tmp_path / f"{name}.urdf").write_bytes(written)
    command = [sys.executable, "-c", READ, str(tmp_path)]
    done = subprocess.run(command, capture_output=True, text=True, check=True, timeout=600)
    results, peak = json.loads(done.stdout)
    given = 2.0 * slowness()
    assert {name: took for name, (took, _, _) in results.items() if took > given} == {}
    messages = {name: said for name, (_, said, _) in results.items() if said != "loaded"}
    assert messages.keys() == hostile.keys()
    assert all("fix:" in said for said in messages.values())
    assert "sang" not in done.stdout
    # A message is for people: it does not give back the megabytes that came in.
    assert {name: length for name, (_, _, length) in results.items() if length > 500_000} == {}
    # Of all of them in turn, with Python and MuJoCo: a peak never falls.
    assert peak < 200 * 1024


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "is empty"),
        (b" \n\t ", "is empty"),
        (b"<robot>", r"robot\.urdf:1: is not XML"),
        (b"<robot>\n<link></robot>", r"robot\.urdf:2: is not XML: mismatched tag"),
        (b"<robot/>\n<robot/>", r"robot\.urdf:2: is not XML"),
        (b"<robot a='1' a='2'/>", "is not XML: duplicate attribute"),
        (b"<robot>&nothing;</robot>", r"robot\.urdf:1: is not XML: undefined entity"),
        (b"just words", "is not XML"),
        (b"{'json': 1}", "is not XML"),
        (b"<robot>\x01</robot>", "is not XML"),
        (b"<robot>\xff\xfe\xfa</robot>", "is binary"),
        (b"\x7fELF\x00\x00", "is binary"),
        (b"\x89PNG\r\n\x1a\n\x00\x00\x00\rIHDR", "is binary"),
        (b"PK\x03\x04\x00\x00", "is binary"),
        (b'<?xml version="1.0" encoding="nothing"?><robot/>', "is not XML"),
        (b'<?xml version="1.0" encoding="hex"?><robot/>', "is not XML"),
        (b'<?xml version="1.0" encoding="gb18030"?><robot/>', "is not XML"),
        ("<robot/>".encode("utf-32"), "is binary|is not XML"),
        (b"\n\n<!DOCTYPE r [<!ENTITY a 'b'>]><robot/>", r"robot\.urdf:3: declares the entity 'a'"),
        (b"<!DOCTYPE r SYSTEM 'a.dtd'><robot/>", r"robot\.urdf:1: .*'a\.dtd'"),
        (b"<!DOCTYPE r [\n<!ATTLIST a b CDATA 'x'>]><robot/>", r"robot\.urdf:2: declares attr"),
    ],
)
def test_what_is_no_description_is_refused_with_its_line(content: bytes, message: str) -> None:
    with pytest.raises(RobotError, match=message) as caught:
        parse(content, "robot.urdf")
    assert caught.value.fix


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "latin-1", "ascii"])
def test_encodings_that_say_what_they_are_are_read(encoding: str) -> None:
    named = "bras" if encoding == "ascii" else "épaule"
    said = "" if encoding.startswith("utf") else f'<?xml version="1.0" encoding="{encoding}"?>'
    tree = parse(f'{said}<robot name="{named}"/>'.encode(encoding), "robot.urdf")
    assert tree.get("name") == named


def test_no_encoding_that_python_knows_ends_in_another_error() -> None:
    names = {"utf_7", "idna", "punycode", "rot13", "zlib", "undefined", "utf_8_sig", "cp037"}
    names |= {"unicode_escape", "raw_unicode_escape", "big5", "shift_jis", "cp1252", "koi8_r"}
    for name in sorted(names):
        assert codecs.lookup(name)
        try:
            tree = parse(f'<?xml version="1.0" encoding="{name}"?><robot/>'.encode(), "robot.urdf")
        except RobotError:
            continue
        assert tree.tag == "robot"


def test_elements_keep_their_lines_attributes_text_and_order() -> None:
    text = '<?xml version="1.0"?>\n<!-- a\nnote --><robot name="r">\n<link\nname="a"/>\n'
    text += "<b><c>1 <!-- -->2</c></b>\n<link name='b'>\n</link></robot>"
    tree = parse(text.encode(), "robot.urdf")
    assert [(e.tag, e.line) for e in tree.everything()] == [
        ("robot", 3),
        ("link", 4),
        ("b", 6),
        ("c", 6),
        ("link", 7),
    ]
    assert [link.get("name") for link in tree.children("link")] == ["a", "b"]
    assert tree.child("b").child("c").text == "1 2"
    assert tree.child("nothing") is None
    assert [child.tag for child in tree.children()] == ["link", "b", "link"]
    assert tree.child("link").place == "robot.urdf:4"


def test_the_bounds_are_those_that_are_stated() -> None:
    deep = b"<a>" * DEEPEST + b"</a>" * DEEPEST
    assert sum(1 for _ in parse(deep, "deep.urdf").everything()) == DEEPEST
    with pytest.raises(RobotError, match="nests deeper"):
        parse(b"<a>" + deep + b"</a>", "deep.urdf")
    wide = b"<a>" + b"<b/>" * (MOST_ELEMENTS - 1) + b"</a>"
    assert len(parse(wide, "wide.urdf")) == MOST_ELEMENTS - 1
    with pytest.raises(RobotError, match="or has more than"):
        parse(b"<a>" + b"<b/>" * MOST_ELEMENTS + b"</a>", "wide.urdf")
    assert parse(b"<a>".ljust(MOST_BYTES - 4) + b"</a>", "long.urdf").tag == "a"
    with pytest.raises(RobotError, match="bytes"):
        parse(b"<a>".ljust(MOST_BYTES - 3) + b"</a>", "long.urdf")


PIECES = ["<robot>", "</robot>", "<link name='a'>", "</link>", "<a b='", "'/>", "<!--", "-->", "&"]
PIECES += [
    "<![CDATA[",
    "]]>",
    "<!DOCTYPE r [",
    "]>",
    "<?xml version='1.0'?>",
    "\x00",
    "é",
    " ",
    ">",
]


@settings(deadline=None, max_examples=150)
@given(st.one_of(st.binary(max_size=60), st.lists(st.sampled_from(PIECES), max_size=12)))
def test_any_bytes_are_a_tree_or_refused_by_name(content: bytes | list[str]) -> None:
    written = content if isinstance(content, bytes) else "".join(content).encode()
    try:
        told, line = "", parse(written, "robot.urdf").line
    except RobotError as error:
        told, line = f"{error.where} {error.what} {error.fix}", 0
    assert told.startswith("robot.urdf") == (line == 0)
    assert line == 0 or b"<" in written.replace(b"\x00", b"")
