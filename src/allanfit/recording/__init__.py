"""A still recording from a file, checked and in SI units.

Start with `load`. It returns a `Recording`, whose channels carry their samples, the stretches of
them that can be used, and findings: one plain sentence for everything that is wrong with them.
"""

from ._blocks import Blocks as Blocks
from ._blocks import read_in_blocks as read_in_blocks
from ._formats import contents as contents
from ._formats import is_recording as is_recording
from ._load import load as load
from ._load import recording_of as recording_of
from ._recording import Channel as Channel
from ._recording import Recording as Recording
from ._recording import RecordingError as RecordingError
from ._save import save as save
from ._topics import Topic as Topic
