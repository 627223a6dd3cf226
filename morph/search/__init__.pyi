from .ddp import Plan as Plan
from .search import Problem as Problem
from .target import Simulated as Simulated
from .trajectory.plant import bounds_of as bounds_of
