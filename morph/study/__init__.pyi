from .cell import cells_of as cells_of
from .engine import EngineOptions as EngineOptions
from .run import run as run
