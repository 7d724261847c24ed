"""What a study of many drawn records is asked on the command line, and where its numbers go."""

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import jax

from allanfit.report import write_json


def record_options(
    about: str | None, records: int, arguments: Sequence[str] | None, *switches: str
) -> argparse.Namespace:
    """How many `records`, the folder of the `output`, and `switches`; in double precision."""
    parser = argparse.ArgumentParser(description=about)
    parser.add_argument("--records", type=int, default=records)
    parser.add_argument("--output", type=Path, default=Path("benchmarks/results"))
    for switch in switches:
        parser.add_argument(f"--{switch}", action="store_true")
    jax.config.update("jax_enable_x64", True)
    return parser.parse_args(arguments)


def keep(options: argparse.Namespace, name: str, rows: Any, **more: Any) -> None:
    """Write the rows, and `more`, as `name`.json into the folder that was asked for."""
    options.output.mkdir(parents=True, exist_ok=True)
    document = {"records": options.records, "rows": rows, **more}
    write_json(document, options.output / f"{name}.json")
