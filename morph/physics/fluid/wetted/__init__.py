"""The surface of a link that water touches: a clean solid, a wrap, a hull or a box."""

from morph.physics.fluid.wetted.choose import surface as surface
from morph.physics.fluid.wetted.choose import wetted as wetted
from morph.physics.fluid.wetted.figures import Figures as Figures
from morph.physics.fluid.wetted.figures import figures_of as figures_of
from morph.physics.fluid.wetted.fit import check_density as check_density
from morph.physics.fluid.wetted.fit import fit_of as fit_of
from morph.physics.fluid.wetted.outcome import SurfaceChoice as SurfaceChoice
from morph.physics.fluid.wetted.outcome import Wetted as Wetted
from morph.physics.fluid.wetted.panels import box_drag as box_drag
from morph.physics.fluid.wetted.panels import panel_drag as panel_drag
from morph.physics.fluid.wetted.panels import slow_drag as slow_drag
from morph.physics.fluid.wetted.shapes import every_shape as every_shape
from morph.physics.fluid.wetted.shapes import shapes_of as shapes_of
