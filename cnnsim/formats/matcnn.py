"""Reads MATCNN's ``temlib.m``: MATLAB assignments ``NAME_A = [...]``, ``NAME_B``, ``NAME_I`` and non-linear parts.

``NAME_a`` (function) with ``NAME_Aa`` (weights) is a non-linear A, ``_b`` with ``_Bb`` a non-linear B, ``_d`` with
``_Dd`` a generalised difference: ``[interpolation n x y x y ... code]``. Differences are neighbour minus centre, the
reverse of CANDY's. Codes are digits, 1 for u, 2 for x, 3 for y, the neighbour's first: 11 is u_kl - u_ij, 12 is
u_kl - x_ij; a third digit 1 in front multiplies the difference with f of it: 122 is f(x_kl - x_ij) (x_kl - x_ij). (11,
12 and 122 are documented; the other codes in its files follow the same rule.) ``X_A = Y_A`` is an alias.
Source: the MATCNN toolbox (Rekeczky), ``temlib.m`` and its user guide.
"""

from dataclasses import dataclass, field
from typing import cast

import numpy as np
from numpy.typing import ArrayLike

from cnnsim.formats.candy.lines import decode, split
from cnnsim.formats.matlab_expression import evaluate
from cnnsim.formats.matlab_tokens import Token, statements
from cnnsim.library.imported import Imported, assume_setting, library_name
from cnnsim.network import Argument, Quantity, Table, Template, Term
from cnnsim.network.table import from_pairs
from cnnsim.support import Diagnostics, Floats, InputError
from cnnsim.support.limits import TEMPLATES

_CODES = {"a": 33, "b": 11}  # A: of y_kl - y_ij, B: of u_kl - u_ij; D has its own
_QUANTITIES = {"1": "u", "2": "x", "3": "y"}
_PARTS = ("A", "B", "I", "a", "Aa", "b", "Bb", "d", "Dd")


@dataclass
class MatcnnEntry:
    """The parts of one template in a file, and the line where it begins."""

    name: str
    line: int
    parts: dict[str, Floats] = field(default_factory=dict)
    broken: bool = False


def read_matcnn(data: bytes, report: Diagnostics) -> dict[str, MatcnnEntry]:
    """Return the entries of a file by name; other lines are warnings, wrong assignments errors."""
    values: dict[str, Floats] = {}
    entries: dict[str, MatcnnEntry] = {}
    text = "\n".join(row for _, row in split(decode(data, report), report))
    for tokens in statements(text):
        line = tokens[0].line
        if len(tokens) < 2 or tokens[0].kind != "name" or (tokens[1].kind, tokens[1].text) != ("sign", "="):
            if any(token.kind != "newline" for token in tokens):
                report.warning(line, f"no assignment, not used: {' '.join(token.text for token in tokens)[:40]!r}")
            continue
        target = tokens[0].text
        if len(values) >= TEMPLATES * len(_PARTS):
            raise InputError(f"line {line}: more than {len(values)} assignments; at most that many wanted")
        name, underscore, part = target.rpartition("_")
        entry = MatcnnEntry(name, line)
        if underscore and part in _PARTS:
            entry = entries.setdefault(name, entry)
        else:
            report.note(line, f"{target} is no part of a template; later lines may use it")
        try:
            values[target] = evaluate(_trimmed(tokens[2:]), values)
        except InputError as error:
            report.error(line, f"{target}: {error}")
            entry.broken = True
            continue
        if part in entry.parts:
            report.warning(line, f"{target} again; the last one counts, as in MATLAB")
        entry.parts[part] = values[target]
    if not entries:
        report.error(None, "no NAME_A, NAME_B or NAME_I: this is no template file")
    return entries


def _trimmed(tokens: list[Token]) -> list[Token]:
    while tokens and tokens[-1].kind == "newline":
        tokens = tokens[:-1]
    return tokens


def entry_template(entry: MatcnnEntry, name: str) -> Template:
    """Return the template of an entry.

    Raises:
        InputError: numbers that make no template, a function without weights or the reverse.
    """
    letters = [letter for letter in "abd" if {letter, letter.upper() + letter} & entry.parts.keys()]
    terms = [_term(entry, letter) for letter in letters]
    return Template(entry.parts.get("A", [[0.0]]), entry.parts.get("B", [[0.0]]), _bias(entry), name, terms)


def _term(entry: MatcnnEntry, letter: str) -> Term:
    """Return the non-linear part ``a``, ``b`` or ``d``: interpolation, n, n pairs, for d the code of its arguments."""
    weights = entry.parts.get(letter.upper() + letter)
    if letter not in entry.parts or weights is None:
        raise InputError(f"{entry.name}_{letter} and {entry.name}_{letter.upper()}{letter} wanted, both")
    numbers = entry.parts[letter].ravel()
    pairs = int(numbers[1]) if numbers.size > 1 and 0 < numbers[1] < 1000 else 0
    wanted = 2 + 2 * pairs + (letter == "d")
    if pairs == 0 or numbers[1] != pairs or numbers[0] not in (0, 1) or numbers.size != wanted:
        raise InputError(f"{entry.name}_{letter} is {numbers.tolist()}; interpolation, n and n pairs wanted")
    table = from_pairs(int(numbers[0]), [(float(x), float(y)) for x, y in numbers[2 : 2 + 2 * pairs].reshape(-1, 2)])
    return from_matcnn(np.atleast_2d(weights), table, _CODES.get(letter) or int(numbers[-1]))


def from_matcnn(weights: ArrayLike, table: Table, code: int) -> Term:
    """Return a MATCNN D, A or B type interaction: its weights, its function and its argument code (11, 12, 122, ...).

    Raises:
        InputError: a code that is not of two digits 1 to 3, or of those after a 1.
    """
    digits = str(code)
    if len(digits) not in (2, 3) or not set(digits) <= set(_QUANTITIES) or (len(digits) == 3 and digits[0] != "1"):
        raise InputError(f"MATCNN argument code {code!r}; two digits of 1 (u), 2 (x), 3 (y), perhaps after a 1, wanted")
    of = Argument(*(cast(Quantity, _QUANTITIES[digit]) for digit in digits[-2:]))
    return Term(weights, of, table, of if len(digits) == 3 else None)


def matcnn_templates(entries: dict[str, MatcnnEntry], report: Diagnostics) -> list[Imported]:
    """Return a template for each entry; a wrong entry is reported as an error and omitted."""
    templates = []
    for entry in (entry for entry in entries.values() if not entry.broken):
        name = library_name(entry.name)
        try:
            template = entry_template(entry, name)
        except InputError as error:
            report.error(entry.line, str(error))
            continue
        imported = Imported(
            name, f"MATCNN template {entry.name}; the source does not say what it does.",
            f"Imported from {report.file}, MATCNN entry {entry.name}", template, aliases=(entry.name,),
        )  # fmt: skip
        templates.append(assume_setting(imported, report))
    return templates


def _bias(entry: MatcnnEntry) -> float:
    bias = entry.parts.get("I", np.zeros(()))
    if bias.size != 1:
        raise InputError(f"{entry.name}_I is {bias.shape}; one number wanted")
    return float(bias.ravel()[0])
