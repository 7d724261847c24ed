"""What a study of many drawn records is asked on the command line."""

import argparse
from collections.abc import Sequence
from pathlib import Path

import jax


def record_options(
    about: str | None, records: int, arguments: Sequence[str] | None
) -> argparse.Namespace:
    """How many `records`, and the folder of the `output`; double precision from here on."""
    parser = argparse.ArgumentParser(description=about)
    parser.add_argument("--records", type=int, default=records)
    parser.add_argument("--output", type=Path, default=Path("benchmarks/results"))
    jax.config.update("jax_enable_x64", True)
    return parser.parse_args(arguments)
