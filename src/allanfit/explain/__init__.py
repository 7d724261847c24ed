"""What the five terms leave out of a recording: located, named, modelled and proven.

Start with `explain`. The way of an investigation is told in `_investigate`, which asks in this
order what `values` tell, whether the `strength` of the noise lasts, and which `lines`, `courses` in
time and effects of the `spectrum` there are; `simulation` compares with one.
"""

from ._explain import explain as explain
from ._explain import explain_recording as explain_recording
from ._explanation import ChannelExplanation as ChannelExplanation
from ._explanation import Explanation as Explanation
