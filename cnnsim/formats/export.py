"""Writes templates of the library in other formats."""

from collections.abc import Callable

from cnnsim.formats.candy.entry import entry_to_tem
from cnnsim.formats.candy.write import write_tem
from cnnsim.formats.celnn_json import celnn
from cnnsim.formats.gene import gene
from cnnsim.library.entry import LibraryEntry

WRITERS: dict[str, Callable[[LibraryEntry], str]] = {
    "tem": lambda entry: write_tem(entry_to_tem(entry)),
    "gene": lambda entry: gene(entry.network),
    "json": lambda entry: celnn(entry.network, entry.summary, entry.tags),
}
KEPT: dict[str, str] = {
    "tem": "numbers, input, initial state, boundary, running time",
    "gene": "numbers only; not the boundary, the initial state, the running time",
    "json": "numbers, with the sign of z turned for black = -1; not the boundary, the initial state, the running time",
}
"""What of a template each format holds."""
