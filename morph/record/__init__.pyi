from .load import check_distinct as check_distinct
from .load import load_recordings as load_recordings
from .recording import Channel as Channel
from .recording import Note as Note
from .recording import Recording as Recording
from .write import write as write
