"""What robots, logs and results are suspected of."""

from __future__ import annotations

import json
from typing import NamedTuple

from rivid import _rivid


class Finding(NamedTuple):
    """A note, warning or error, as docs/diagnostics.md lists them."""

    code: str
    severity: str
    subject: str
    text: str

    def explain(self) -> str:
        """Cause and cure."""
        return _rivid.explanation(self.code) or ""

    def __str__(self) -> str:
        about = f"{self.subject}: " if self.subject else ""
        return f"{self.severity} [{self.code}] {about}{self.text}"


def findings_of(document: str | list[dict[str, str]]) -> list[Finding]:
    """The findings of a document: the text of one, or its list of warnings."""
    items = json.loads(document)["findings"] if isinstance(document, str) else document
    return [Finding(item["code"], item["severity"], item["subject"], item["text"]) for item in items]
