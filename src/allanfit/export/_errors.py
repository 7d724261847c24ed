"""The one error of this stage."""


class ExportError(ValueError):
    """A fit cannot be exported; the message says why and what to do, in one sentence."""
