"""Files that people write by hand: a mapping in YAML, of which JSON is a part."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from .extras import needs


def read_mapping(path: Path, what: str, hint: str, error: type[ValueError]) -> Mapping[str, Any]:
    """The mapping in a file.

    **Arguments**: `what` the file should hold and a `hint` of what to give, for messages.

    **Raises** `error` in one sentence if the file cannot be read or holds no mapping.
    """
    with needs("'allanfit[cli]'", "YAML files", error):
        import yaml
    try:
        document = yaml.safe_load(path.read_text(encoding="utf-8-sig"))
    except (OSError, UnicodeDecodeError) as failure:
        reason = getattr(failure, "strerror", None) or "it is not text"
        raise error(f"Cannot read {what} from {path.name}: {reason}.") from failure
    except (yaml.YAMLError, RecursionError) as failure:
        raise error(f"{path.name} is neither JSON nor YAML; give {hint}.") from failure
    if not isinstance(document, Mapping):
        raise error(f"{path.name} holds no {what}; give {hint}.")
    return document
