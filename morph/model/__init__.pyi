from .candidate import Candidate as Candidate
from .ensemble import Ensemble as Ensemble
from .hypothesis import Hypothesis as Hypothesis
from .latent.online import OnlineInference as OnlineInference
from .latent.online import hidden as hidden
from .latent.parameter_attribution import explain as explain
from .latent.unknowns import turned as turned
from .latent.unknowns import unknowns as unknowns
