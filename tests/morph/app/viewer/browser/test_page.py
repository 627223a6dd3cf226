from __future__ import annotations

import re
import sys
from collections.abc import Callable
from html import escape
from pathlib import Path
from typing import Any

from morph.app.viewer.view_request import ViewRequest
from morph.app.viewer.views.views import makers
from morph.body.load import load

HOSTILE = "<img src=x onerror=window.hacked=1>"

DESCRIPTION = """<mujoco model="{name}"><worldbody><body name="{name}link" pos="0 0 1">
  <joint name="{name}joint" type="hinge" axis="0 1 0" range="-1 1"/>
  <geom name="{name}shape" type="capsule" size="0.05" fromto="0 0 0 0 0 -0.5" mass="1"/>
</body></worldbody>
<actuator><motor name="{name}motor" joint="{name}joint" ctrlrange="-1 1"/></actuator></mujoco>"""


def test_a_page_is_drawn_by_webgl_asks_nobody_else_and_runs_nothing_that_names_say(
    served: Callable[..., Any], look: Callable[..., Any], blank: Callable[..., Any], tmp_path: Path
) -> None:
    file = tmp_path / "robot.xml"
    file.write_text(DESCRIPTION.format(name=escape(HOSTILE)), encoding="utf-8")
    robot = load(str(file))
    # What this is about is there: nobody has refused or mended the names.
    assert robot.links[0].name == f"{HOSTILE}link"
    found, _ = makers(ViewRequest(robots=(robot,), asked=(str(file),)))
    address = served(views=lambda: [make() for make in found]).address
    person = look(address)
    the_canvas_is_drawn_by_webgl(person)
    for tab in ("Compare", "Design"):
        person.press(tab)
        person.until(lambda: HOSTILE in person.text(), f"{tab} shows the name as text")
        assert person.page.locator("img[src='x']").count() == 0
        assert person.page.evaluate("window.hacked") is None
    port = address.rsplit(":", 1)[1].split("/")[0]
    own = re.compile(rf"(blob:)?(https?|ws)://(localhost|127\.0\.0\.1):{port}/|data:")
    assert person.requests
    assert [each for each in person.requests if not own.match(each + "/")] == []
    # The ground alone has hundreds of colours, since it fades; a page without anything has one.
    nobody = blank()
    nobody.page.set_content("<canvas style='width:1280px;height:760px'></canvas>")
    assert nobody.colours() == 1


def the_canvas_is_drawn_by_webgl(person: Any) -> None:
    (said,) = [each for each in person.said if "WebGL support" in each]
    (renderer,) = re.findall(r"renderer: (.+), vendor:", said)
    sys.stdout.write(f"WebGL renderer: {renderer}\n")
    assert renderer.strip()
    assert "WebGL support: true" in said
    # A busy machine draws late.
    person.until(lambda: person.colours() > 200, "a canvas of more than 200 colours")
