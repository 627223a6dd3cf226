from __future__ import annotations

import numpy as np
import pytest

from morph.print.deposit import deposit
from morph.print.gcode import lines
from morph.print.printer import Profile

AREA = np.pi / 4 * 1.75**2
"""Of the filament, mm2; with 1.24e-6 kg/mm3 one millimetre weighs 2.98 mg."""
LINE = b"M83\nG1 X10 Y20 Z0.4\n;TYPE:Perimeter\n;WIDTH:0.5\n;HEIGHT:0.2\nG1 X22 Y36 E2\n"
"""One line of 20 mm from (10, 20) along (0.6, 0.8), its top at 0.4 mm."""


def test_one_line_weighs_what_a_box_of_its_size_and_filament_does(pla: Profile) -> None:
    weight = deposit(lines(LINE), pla).weight
    mass = 2 * AREA * 1.24e-6
    assert weight.mass == pytest.approx(mass)
    assert weight.com == pytest.approx([16e-3, 28e-3, 0.3e-3])
    # In the line's own axes, m / 12 times the squares of the other two lengths.
    along, across, up = 20e-3, 0.5e-3, 0.2e-3
    own = np.diag([across**2 + up**2, along**2 + up**2, along**2 + across**2]) * mass / 12
    turn = np.array([[0.6, -0.8, 0], [0.8, 0.6, 0], [0, 0, 1]])
    assert weight.inertia == pytest.approx(turn @ own @ turn.T, abs=1e-15)


def test_two_lines_on_each_other_are_about_their_common_centre(pla: Profile) -> None:
    both = deposit(lines(LINE + b"G1 Z0.6\nG1 X10 Y20 E1\n"), pla).weight
    # Masses 2 to 1, at 0.3 and 0.5 mm.
    assert both.com[2] == pytest.approx((2 * 0.3e-3 + 0.5e-3) / 3)
    assert both.mass == pytest.approx(3 * AREA * 1.24e-6)


def test_support_skirt_and_priming_are_weighed_apart(pla: Profile) -> None:
    away = b";TYPE:Skirt/Brim\nG1 X50 E1\n;TYPE:Support material\nG1 X60 E2\n"
    more = b";TYPE:Support material interface\nG1 X70 E4\n;TYPE:Custom\nG1 X80 E8\n"
    alone = deposit(lines(LINE), pla)
    found = deposit(lines(LINE + away + more), pla)
    assert found.away == pytest.approx(15 * AREA * 1.24e-6)
    assert found.weight.mass == alone.weight.mass
    assert found.weight.com == pytest.approx(alone.weight.com)
    assert sum(found.by_feature.values()) == pytest.approx(17 * AREA * 1.24e-6)
    assert found.by_feature["Support material"] == pytest.approx(2 * AREA * 1.24e-6)


def test_what_is_all_support_leaves_nothing(pla: Profile) -> None:
    left = deposit(lines(LINE.replace(b"Perimeter", b"Support material")), pla)
    assert left.weight.mass == 0.0
    assert np.array_equal(left.weight.inertia, np.zeros((3, 3)))


def test_a_hundred_lines_side_by_side_weigh_as_the_sheet_that_they_fill(pla: Profile) -> None:
    # 100 lines of 50 mm, 0.5 mm wide: a sheet of 50 x 50 x 0.2 mm, 500 mm3 of plastic.
    push = 500 / 100 / AREA
    rows = "".join(f"G0 X0 Y{0.25 + 0.5 * row}\nG1 X50 E{push}\n" for row in range(100)).encode()
    found = deposit(lines(b"M83\nG1 Z0.2\n;WIDTH:0.5\n;HEIGHT:0.2\n" + rows), pla).weight
    mass = 500 * 1.24e-6
    assert found.mass == pytest.approx(mass)
    assert found.com == pytest.approx([25e-3, 25e-3, 0.1e-3])
    # Boxes of equal mass, set side by side, are exactly the large box.
    side, thick = 50e-3**2, 0.2e-3**2
    assert np.diag(found.inertia) == pytest.approx(
        np.array([side + thick, side + thick, 2 * side]) * mass / 12
    )
