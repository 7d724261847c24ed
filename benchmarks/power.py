"""How often can an effect be found at all, with so few false alarms?

    python -m benchmarks.power

An effect of strength lambda gains twice the log-likelihood of a non-central chi-square with that
parameter, if the noise beside it is known and the search misses no maximum. It raises an alarm
when chance gains as much nowhere that it is looked for, at the alarm that explain uses. The table
sets the shares beside the aims of `benchmarks.concealed`: where they fall short of an aim, only
fewer places to look in or more false alarms would reach it.
"""

from collections.abc import Callable

import numpy as np
from scipy.optimize import root_scalar
from scipy.stats import ncx2

from allanfit.explain._chance import _SMOOTH, course_log_chance, log_chance
from allanfit.explain._investigate import ALARM
from allanfit.explain.lines._lines import line_log_chance
from allanfit.explain.lines._taken import LINE_ALARM

SAMPLES, KNOWN = 300_000, 1e5
STRENGTHS = (12.0, 25.0, 36.0, 50.0, 64.0, 100.0)


def threshold(log_p: Callable[[float], float], alarm: float = ALARM) -> float:
    """The gain that chance reaches as rarely as the alarm."""
    found = root_scalar(lambda gain: log_p(gain) - np.log(alarm), bracket=(1.0, 400.0))
    return float(found.root)


def effects() -> dict[str, tuple[float, int]]:
    """What each effect has to gain, and the parameters that it gains by."""
    found = {
        name: (threshold(lambda gain, name=name: log_chance(name, gain)), parameters)
        for name, (_, parameters) in _SMOOTH.items()
        # Neither is an effect of its own.
        if name not in ("droop", "bump")
    }
    for name, frequency in (("sinusoid", 0.25), ("sinusoid of 1000 periods", 1000 / SAMPLES)):
        found[name] = (
            threshold(
                lambda gain, frequency=frequency: line_log_chance(gain / 2, frequency, SAMPLES),
                LINE_ALARM * ALARM,
            ),
            # The frequency is the best one near the true one.
            3,
        )
    found["temperature, measured"] = (threshold(lambda gain: course_log_chance(gain, 1, KNOWN)), 1)
    # A ring of unknown place, frequency and damping: some thirty of these at every sample.
    found["disturbance"] = (
        threshold(lambda gain: course_log_chance(gain, 2, KNOWN, places=30.0 * SAMPLES)),
        2,
    )
    return found


def main(arguments=None):
    del arguments
    print(f"A record of {SAMPLES:,} samples, a false alarm of {ALARM:g} in each family.\n")
    print("| effect | has to gain |" + "".join(f" lambda {each:g} |" for each in STRENGTHS))
    print("|---" * (2 + len(STRENGTHS)) + "|")
    for name, (needed, parameters) in effects().items():
        shares = "".join(f" {ncx2.sf(needed, parameters, each):.2f} |" for each in STRENGTHS)
        print(f"| {name} | {needed:.1f} |{shares}")


if __name__ == "__main__":
    main()
