"""The fit document as a file for other programs."""

import json
import os
from collections.abc import Mapping
from typing import Any

from ._errors import ReportError
from ._files import write_whole


def write_json(document: Mapping[str, Any], target: str | os.PathLike[str]) -> None:
    """Write a document as strict JSON, to a path or to standard output for "-".

    The file is there whole or not at all, in ASCII, with the keys in the document's order.

    **Raises** `ReportError` when the document holds what JSON cannot (a NaN, an array), and when
    the file cannot be written.

    ```python
    write_json(document, "fit.json")
    ```
    """
    try:
        text = json.dumps(document, allow_nan=False, indent=1)
    except (TypeError, ValueError) as error:
        raise ReportError(
            f"The document is not strict JSON ({error}): "
            "give plain numbers, text, lists and dictionaries, and null for what is undefined."
        ) from error
    write_whole(text + "\n", target)
