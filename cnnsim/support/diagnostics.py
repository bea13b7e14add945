"""Diagnostics of an imported file: notes, warnings and errors, each with its line number."""

from dataclasses import dataclass, field
from typing import Literal

Severity = Literal["note", "warning", "error"]


@dataclass(frozen=True)
class Diagnostic:
    """One remark. A note is harmless, a warning should be checked, after an error the content cannot be trusted."""

    severity: Severity
    line: int | None
    message: str


@dataclass
class Diagnostics:
    """The remarks on one file, in the order in which they were found."""

    file: str
    items: list[Diagnostic] = field(default_factory=list)

    def note(self, line: int | None, message: str) -> None:
        """Add a harmless remark."""
        self.items.append(Diagnostic("note", line, message))

    def warning(self, line: int | None, message: str) -> None:
        """Add a remark that should be checked."""
        self.items.append(Diagnostic("warning", line, message))

    def error(self, line: int | None, message: str) -> None:
        """Add an error: the content cannot be trusted."""
        self.items.append(Diagnostic("error", line, message))

    def of(self, severity: Severity) -> list[Diagnostic]:
        """Return the remarks of one severity."""
        return [item for item in self.items if item.severity == severity]

    @property
    def failed(self) -> bool:
        """True if there is an error."""
        return bool(self.of("error"))

    def lines(self, notes: bool = False) -> list[str]:
        """Return the remarks as ``file:line: severity: message``, notes only if asked for."""
        return [
            f"{self.file}:{'' if item.line is None else f'{item.line}:'} {item.severity}: {item.message}"
            for item in self.items
            if notes or item.severity != "note"
        ]
