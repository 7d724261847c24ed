"""Files that people write by hand: a mapping in JSON or YAML."""

import json
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from .extras import needs
from .recording import RecordingError
from .recording._files import require_file

_TAB_INDENT = re.compile(r"^ *\t", re.MULTILINE)


def read_mapping(path: Path, what: str, hint: str, error: type[ValueError]) -> Mapping[str, Any]:
    """The mapping in a file.

    **Arguments**: `what` the file should hold and a `hint` of what to give, for messages.

    **Raises** `error` in one sentence if the file cannot be read or holds no mapping.
    """
    try:
        require_file(path)
        text = path.read_text(encoding="utf-8-sig")
    except RecordingError as failure:
        raise error(str(failure)) from failure
    except (OSError, UnicodeDecodeError) as failure:
        reason = getattr(failure, "strerror", None) or "it is not text"
        raise error(f"Cannot read {what} from {path.name}: {reason}.") from failure
    try:
        document = _document(text, error)
    except _NameTwiceError as failure:
        raise error(f"{path.name} names {str(failure)!r:.60} twice: leave one out.") from failure
    # Whatever a number of 5000 digits or a thousand lists in each other make the parsers raise.
    except (_UnreadableError, ValueError, RecursionError) as failure:
        if isinstance(failure, error):
            raise
        if _TAB_INDENT.search(text) and not text.lstrip().startswith(("{", "[")):
            raise error(
                f"{path.name} has lines that begin with tabs, which YAML does not allow: indent "
                "with spaces."
            ) from failure
        raise error(
            f"{path.name} is neither JSON nor YAML without anchors; give {hint}."
        ) from failure
    if not isinstance(document, Mapping):
        raise error(f"{path.name} holds no {what}; give {hint}.")
    return {str(name): value for name, value in document.items()}


class _NameTwiceError(Exception):
    """A mapping has a name twice, of which parsers would take the last without a word."""


class _UnreadableError(Exception):
    """A text is not what is read here."""


def _document(text: str, error: type[ValueError]) -> Any:
    """What JSON says or else YAML, each name once and no part of it used twice.

    **Raises:** `_NameTwiceError`; `_UnreadableError`, `ValueError` or `RecursionError` if it is
    neither.
    """
    try:
        return json.loads(text, object_pairs_hook=_once)
    except json.JSONDecodeError:
        pass
    with needs("'allanfit[cli]'", "YAML files", error):
        import yaml

    class Loader(yaml.SafeLoader):
        def compose_node(self, parent: Any, index: Any) -> Any:
            # Anchors let a few lines stand for more values than any memory holds.
            if self.check_event(yaml.AliasEvent):
                raise _UnreadableError("a part is used twice")
            return super().compose_node(parent, index)

        def construct_mapping(self, node: Any, deep: bool = False) -> dict[Any, Any]:
            names = [(self.construct_object(key, deep=True), None) for key, _ in node.value]
            _once([(str(name), value) for name, value in names])
            return super().construct_mapping(node, deep)

    try:
        return yaml.load(text, Loader)
    except yaml.YAMLError as failure:
        raise _UnreadableError(str(failure)) from failure


def _once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    known: dict[str, Any] = {}
    for name, value in pairs:
        if name in known:
            raise _NameTwiceError(name)
        known[name] = value
    return known
