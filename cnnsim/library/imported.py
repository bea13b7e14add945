"""Imported: a library entry read from a file of another system."""

import re
from dataclasses import dataclass, replace

from cnnsim.library.entry import LibraryEntry, Role
from cnnsim.library.write import template_text
from cnnsim.network import ZERO_FLUX, AnyTemplate, Boundary, Template
from cnnsim.support import Diagnostics, InputError
from cnnsim.support.files import LONGEST_NAME


@dataclass(frozen=True)
class Imported(LibraryEntry):
    """An imported entry; ``missing`` is the reason why it cannot be written, or empty."""

    missing: str = ""

    def with_note(self, text: str) -> "Imported":
        """Return the template with one more sentence in its note."""
        return replace(self, note=f"{self.note} {text}".strip())

    def text(self) -> str:
        """Return the text of its template file.

        Raises:
            InputError: it cannot be written.
        """
        if self.missing:
            raise InputError(f"template {self.name!r}: {self.missing}")
        return template_text(self)


def plain(template: AnyTemplate, place: str) -> Template:
    """Return a linear template of one layer.

    Raises:
        InputError: another kind of template, which the format ``place`` cannot have.
    """
    if isinstance(template, Template) and template.linear:
        return template
    raise InputError(f"template {template.name!r} is not linear or of several layers; {place} holds no such template")


def library_name(text: str) -> str:
    """Return a name in lower case with hyphens: ``CCD_HOR`` becomes ``ccd-hor``."""
    return re.sub(r"[^a-z0-9]+", "-", text.lower())[:LONGEST_NAME].strip("-") or "unnamed"


def assume_setting(imported: Imported, report: Diagnostics, boundary: Boundary | None = None) -> Imported:
    """Fill in the initial state and perhaps the boundary, which a format lacks, and add a warning."""
    role: Role = "picture" if imported.network.reads_input else "none"
    open_ends = "initial state" if boundary else "boundary and initial state"
    taken = "the picture was taken" if boundary else "zero-flux and the picture were taken"
    text = f"The source says nothing of {open_ends}; {taken}."
    report.warning(None, f"{imported.name}: {text} Check the file that is written")
    return replace(imported, input=role, boundary=boundary or ZERO_FLUX).with_note(text)
