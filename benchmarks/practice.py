"""The practice set, where it is at hand: is each cause named, and nothing else?

    python -m benchmarks.practice [NAME ...]

Recordings of another's device simulator with their answers (../shared/practice). They are for
trying things, never to tune to; what was right there once and is no more is a fault.
"""

import argparse
import json
import sys
import time

import jax

import allanfit

from .concealed._real import SHARED

PRACTICE = SHARED.parent / "practice"


def main(arguments=None) -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("names", nargs="*", help="of recordings; all by default")
    names = parser.parse_args(arguments).names
    if not PRACTICE.is_dir():
        print("there is no practice set beside this checkout")
        return 0
    jax.config.update("jax_enable_x64", True)
    key = json.loads((PRACTICE / "key.json").read_text())
    wrong = 0
    for name in names or sorted(key):
        start = time.perf_counter()
        recording = allanfit.load(PRACTICE / f"{name}.npz")
        (channel,) = allanfit.explain(recording, seed=0).to_dict()["channels"]
        true = sorted(effect["effect"] for effect in key[name]["effects"])
        named = sorted({effect["name"] for effect in channel["effects"]})
        right = named == true and channel["verdict"] == ("explained" if true else "consistent")
        wrong += not right
        low, high = channel["coefficients_after"]["N"]["intervals"]["0.95"]
        held = low <= key[name]["coefficients"]["N"] <= high
        print(
            f"{name}  {'right' if right else 'WRONG'}  {channel['verdict']}: "
            f"{', '.join(named) or 'nothing'} (is {', '.join(true) or 'nothing'}); "
            f"N {'held' if held else 'missed'}; {time.perf_counter() - start:.1f} s",
            flush=True,
        )
    print(f"{len(names or key) - wrong} of {len(names or key)} right")
    return int(wrong > 0)


if __name__ == "__main__":
    sys.exit(main())
