from .body.load import load as load
from .inference.diagnose import diagnose as diagnose
from .model.comparison import compare as compare
from .physics import EFFECTS as EFFECTS
from .physics.worlds import world as world
from .policy.store import load_policy as load_policy
from .record.load import load_recordings as load_recordings
from .record.recording import Channel as Channel
from .record.recording import Recording as Recording
from .sim.simulate import simulate as simulate
from .sim.simulator import Simulator as Simulator

__version__: str
