from .rounds import rounds as rounds
from .source import SimulatedTask as SimulatedTask
