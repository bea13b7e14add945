"""Cuts MATLAB text into statements and tokens, as far as template files need it."""

import re
from collections.abc import Iterator
from dataclasses import dataclass

_TOKEN = re.compile(
    r"(?P<number>(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)|(?P<name>[A-Za-z]\w*)|(?P<sign>\.\*|\./|[-+*/()\[\],;=])"
    r"|(?P<blank>[ \t]+)|(?P<newline>\n)|(?P<other>.)",
    re.ASCII,
)
_BEGINS = re.compile(r"\s*[A-Za-z]\w*\s*=")


@dataclass(frozen=True)
class Token:
    """A piece of text: its kind (number, name, sign, newline, end, other), the text, its line, and blanks around it."""

    kind: str
    text: str
    line: int
    blank_before: bool = False
    blank_after: bool = False


def statements(text: str) -> Iterator[list[Token]]:
    """Yield the tokens of each statement.

    ``%`` starts a comment, ``...`` carries a line on; a statement ends with its line or with ``;`` outside of brackets.
    """
    current: list[Token] = []
    depth = 0
    rows = text.split("\n")
    for token in _tokens(rows):
        depth += (token.text in "[(") - (token.text in "])") if token.kind == "sign" else 0
        if depth <= 0 and (token.kind == "newline" or (token.kind == "sign" and token.text == ";")):
            if current:
                yield current
            current, depth = [], 0
            continue
        if token.kind == "newline" and token.line < len(rows) and _BEGINS.match(rows[token.line]):
            yield current  # a bracket that was never closed must not swallow the rest of the file
            current, depth = [], 0
            continue
        current.append(token)
    if current:
        yield current


def _tokens(rows: list[str]) -> Iterator[Token]:
    for number, row in enumerate(rows, start=1):
        body = row.split("%", 1)[0]
        body, carried, _ = body.partition("...")
        pieces = [(match.lastgroup or "other", match[0]) for match in _TOKEN.finditer(body)]
        for at, (kind, piece) in enumerate(pieces):
            if kind != "blank":
                before = at == 0 or pieces[at - 1][0] == "blank"
                after = at + 1 < len(pieces) and pieces[at + 1][0] == "blank"
                yield Token(kind, piece, number, before, after)
        if not carried:
            yield Token("newline", "\n", number)
