from .app.api.align import align as align
from .app.api.learn import learn as learn
from .app.api.loop import loop as loop
from .app.api.print_package import print_package as print_package
from .app.api.transfer import transfer as transfer
from .app.api.view import view as view
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
