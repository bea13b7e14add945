"""HTML for notebooks: matrices and tables, and embedded pictures."""

from base64 import b64encode
from collections.abc import Iterable, Mapping, Sequence
from html import escape

from cnnsim.support.values import Array

_CELL = 'style="text-align:right; padding:1px 7px"'
_NAME = 'style="text-align:left; vertical-align:top; padding:1px 12px 1px 0"'
_TEXT = 'style="text-align:left; padding:1px 0"'


def heading(name: str, text: str = "") -> str:
    """Return a line with a name in bold and a text."""
    return f"<div><b>{escape(name)}</b>{': ' if text else ''}{escape(text)}</div>"


def matrices(named: Mapping[str, Array]) -> str:
    """Return matrices side by side with their names."""
    blocks = (f'<td {_CELL}>{escape(name)} =</td><td style="padding-right:24px">{_matrix(values)}</td>'
              for name, values in named.items())  # fmt: skip
    return f"<table><tr>{''.join(blocks)}</tr></table>"


def facts(named: Mapping[str, object]) -> str:
    """Return a table of names and values."""
    return table(((name, str(value)) for name, value in named.items()), ())


def table(rows: Iterable[Sequence[str]], head: Sequence[str]) -> str:
    """Return a table of texts with titles."""
    first = "".join(f"<th {_NAME}>{escape(title)}</th>" for title in head)
    lines = ("".join(f"<td {_NAME if i == 0 else _TEXT}>{escape(text)}</td>" for i, text in enumerate(row))
             for row in rows)  # fmt: skip
    body = "".join(f"<tr>{line}</tr>" for line in lines)
    return f"<table>{f'<tr>{first}</tr>' if head else ''}{body}</table>"


def image(png: bytes, width: int | None = None) -> str:
    """Return an embedded picture, at most ``width`` pixels wide."""
    style = "" if width is None else f' style="max-width:{width}px"'
    return f'<img src="data:image/png;base64,{b64encode(png).decode()}"{style}/>'


def _matrix(values: Array) -> str:
    rows = ("".join(f"<td {_CELL}>{value:.6g}</td>" for value in row) for row in values)
    return f"<table>{''.join(f'<tr>{row}</tr>' for row in rows)}</table>"
