"""What the five terms leave out of a recording: located, named, modelled and proven.

Start with `explain`. The way of an investigation is told in `_investigate`.
"""

from ._explain import ChannelExplanation as ChannelExplanation
from ._explain import Explanation as Explanation
from ._explain import explain as explain
from ._explain import explain_recording as explain_recording
