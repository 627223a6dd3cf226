from .closed_loop import closed_loop as closed_loop
from .simulate import simulate as simulate
from .simulator import Simulator as Simulator
