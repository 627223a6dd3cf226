from .calibrate import calibrated as calibrated
from .fit import fit as fit
