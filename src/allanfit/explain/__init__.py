"""What the five terms leave out of a recording: located, named, modelled and proven.

Start with `explain`. The way of an investigation is told in `_investigate`.
"""

from ._explain import explain as explain
from ._explain import explain_recording as explain_recording
from ._explanation import ChannelExplanation as ChannelExplanation
from ._explanation import Explanation as Explanation
