"""Works out literal MATLAB expressions: numbers, ``+ - * /``, parentheses, brackets and names. Nothing is executed.

Grammar: ``sum = product {("+" | "-") product}``, ``product = factor {("*" | "/") factor}``,
``factor = ["+" | "-"] (number | name | "(" sum ")" | "[" rows "]")``. In brackets a blank before a sign and none after
it starts a new entry (``[1 -1]`` has two, ``[1 - 1]`` has one), as in MATLAB.
"""

from collections.abc import Mapping

import numpy as np

from cnnsim.formats.matlab_tokens import Token
from cnnsim.formats.numbers import number
from cnnsim.support import Floats, InputError

_DEEPEST = 40


def evaluate(tokens: list[Token], names: Mapping[str, Floats]) -> Floats:
    """Return the value of an expression, a scalar as an array of no axes.

    Raises:
        InputError: anything outside the grammar, an unknown name, shapes that do not fit, a value that is not finite.
    """
    parser = _MatlabParser(tokens, names)
    value = parser.sum(False)
    if parser.token.kind != "end":
        raise InputError(f"{parser.token.text!r} after the end of the expression")
    if not np.isfinite(value).all():
        raise InputError("a value that is not finite")
    return value


class _MatlabParser:
    def __init__(self, tokens: list[Token], names: Mapping[str, Floats]) -> None:
        self.tokens = [*tokens, Token("end", "the end", tokens[-1].line if tokens else 0)]
        self.names = names
        self.at = 0
        self.depth = 0

    @property
    def token(self) -> Token:
        return self.tokens[self.at]

    def take(self, *texts: str) -> str | None:
        """Return the next token and go on, if it is a sign among these."""
        if self.token.kind == "sign" and self.token.text in texts:
            self.at += 1
            return self.tokens[self.at - 1].text
        return None

    def sum(self, in_brackets: bool) -> Floats:
        value = self.product(in_brackets)
        while not (in_brackets and self.starts_entry()) and (sign := self.take("+", "-")):
            other = self.product(in_brackets)
            value = _combine(value, sign, other)
        return value

    def starts_entry(self) -> bool:
        return self.token.blank_before and not self.token.blank_after

    def product(self, in_brackets: bool) -> Floats:
        value = self.factor()
        while sign := self.take("*", "/", ".*", "./"):
            value = _combine(value, sign, self.factor())
        return value

    def factor(self) -> Floats:
        sign = 1.0
        while word := self.take("+", "-"):
            sign = -sign if word == "-" else sign
        token = self.token
        if token.kind == "number":
            self.at += 1
            return np.asarray(sign * number(token.text))
        if token.kind == "name":
            self.at += 1
            if token.text not in self.names:
                raise InputError(f"the name {token.text!r} is not defined above")
            return np.asarray(sign * self.names[token.text])
        if self.token.text not in ("(", "[") or token.kind != "sign":
            raise InputError(f"{token.text[:20]!r}; a number, a name or a bracket wanted")
        self.at += 1
        self.depth += 1
        if self.depth > _DEEPEST:
            raise InputError(f"brackets nested deeper than {_DEEPEST}")
        if token.text == "[":
            value = self.rows()
        else:
            value = self.sum(False)
            if not self.take(")"):
                raise InputError(f"{self.token.text!r}; ')' wanted")
        self.depth -= 1
        return np.asarray(sign * value)

    def rows(self) -> Floats:
        rows: list[list[float]] = [[]]
        while not self.take("]"):
            if self.take(";") or self.token.kind == "newline":
                self.at += self.token.kind == "newline"
                rows.append([])
            elif not (self.take(",") and rows[-1]):
                entry = self.sum(True)
                if entry.ndim:
                    raise InputError("a matrix inside a matrix")
                rows[-1].append(float(entry))
        rows = [row for row in rows if row]
        if not rows or len({len(row) for row in rows}) != 1:
            raise InputError(f"rows of {', '.join(str(len(row)) for row in rows) or 'no'} entries; equal rows wanted")
        return np.array(rows)


def _combine(a: Floats, sign: str, b: Floats) -> Floats:
    if a.ndim and b.ndim and (sign in ("*", "/") or a.shape != b.shape):
        raise InputError(f"'{sign}' between a matrix {a.shape} and a matrix {b.shape}")
    if sign in ("/", "./") and not b.all():
        raise InputError("division by zero")
    with np.errstate(over="ignore", invalid="ignore"):
        if sign in ("+", "-"):
            return np.asarray(a + b if sign == "+" else a - b)
        return np.asarray(a * b if sign in ("*", ".*") else a / b)
