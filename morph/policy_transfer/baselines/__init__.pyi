from .alone import Alone as Alone
from .source import Source as Source
