from .folder import FolderLink as FolderLink
from .online import OnlineRobot as OnlineRobot
from .online import Service as Service
from .outbox import Post as Post
from .policies import Policies as Policies
