"""Rules as logical and arithmetical expressions over the cells of a window: ``c and (n + e + s + w) < 4``.

    or < xor < and < not < comparison (< <= > >= == !=, also chained) < + - < * % < unary -

A cell is 1 if it is black and 0 if it is white; a number counts as true if it is not 0. Names: nw n ne w c e sw s se,
``x`` (the cell's own initial state), ``ring4`` = n + e + s + w, ``ring8`` = all eight neighbours, ``all9`` with the
cell itself; ``black`` and ``white`` are 1 and 0. Nothing is executed: the parser below computes with whole tables.
"""

import operator
import re
from collections.abc import Callable
from typing import Any

import numpy as np

from cnnsim.prototyping.design.rule import NAMES, WindowRule, windows
from cnnsim.support import InputError, Integers

Values = Integers

_TOKEN = re.compile(r"\s*(?:(\d+)|([A-Za-z_]\w*)|(<=|>=|==|!=|[-+*%()<>]))")
_COMPARE: dict[str, Callable[[Any, Any], Any]] = {
    "<": operator.lt, "<=": operator.le, ">": operator.gt, ">=": operator.ge, "==": operator.eq, "!=": operator.ne,
}  # fmt: skip
_WORDS = {"and", "or", "xor", "not"}
_LONGEST = 4000
_DEEPEST = 60
_LARGEST = 10**9


def parse_rule(text: str) -> WindowRule:
    """Return the rule of an expression.

    Raises:
        InputError: what was found where, and what was wanted.
    """
    return _RuleParser(text).rule()


class _RuleParser:
    """Recursive descent over a list of tokens; every method returns its expression's value in all windows."""

    def __init__(self, text: str) -> None:
        self.text = text
        if len(text) > _LONGEST:
            raise InputError(f"a rule of {len(text)} characters; at most {_LONGEST} wanted")
        self.tokens = self._split()
        self.at = self.depth = 0
        cells = (windows(10) > 0).astype(np.int64)
        self.names: dict[str, Values] = {name: cells[:, i] for i, name in enumerate(NAMES)}
        self.names["ring4"] = cells[:, [1, 3, 5, 7]].sum(axis=1)
        self.names["all9"] = cells[:, :9].sum(axis=1)
        self.names["ring8"] = self.names["all9"] - cells[:, 4]
        self.names |= {"black": np.ones(1024, dtype=np.int64), "white": np.zeros(1024, dtype=np.int64)}

    def _split(self) -> list[tuple[str, int]]:
        tokens, at, end = [], 0, len(self.text.rstrip())
        while at < end:
            found = _TOKEN.match(self.text, at)
            if found is None:
                at += len(self.text[at:]) - len(self.text[at:].lstrip())
                raise InputError(f"rule {self.text!r}: {self.text[at]!r} at character {at + 1} means nothing here")
            tokens.append((found.group().strip(), found.start(found.lastindex or 0) + 1))
            at = found.end()
        return [*tokens, ("", end + 1)]

    def rule(self) -> WindowRule:
        value = self._or()
        if self._next:
            self._wrong("an operator or the end")
        black = np.where(value != 0, 1, -1).astype(np.int8)
        looks_at_state = any(token == "x" for token, _ in self.tokens)
        return WindowRule(black if looks_at_state else black[::2], self.text.strip())

    @property
    def _next(self) -> str:
        return self.tokens[self.at][0]

    def _take(self, *wanted: str) -> str | None:
        if self._next not in wanted or not self._next:
            return None
        self.at += 1
        return self.tokens[self.at - 1][0]

    def _wrong(self, wanted: str) -> None:
        token, place = self.tokens[self.at]
        raise InputError(f"rule {self.text!r}: {token or 'the end'!r} at character {place}; {wanted} wanted")

    def _or(self) -> Values:
        value = self._xor()
        while self._take("or"):
            value = _truth(value) | _truth(self._xor())
        return value

    def _xor(self) -> Values:
        value = self._and()
        while self._take("xor"):
            value = _truth(value) ^ _truth(self._and())
        return value

    def _and(self) -> Values:
        value = self._not()
        while self._take("and"):
            value = _truth(value) & _truth(self._not())
        return value

    def _not(self) -> Values:
        turns = 0
        while self._take("not"):
            turns += 1
        value = self._comparison()
        return value if not turns else _truth(value) ^ (turns % 2)

    def _comparison(self) -> Values:
        left, holds = self._sum(), None
        while sign := self._take(*_COMPARE):
            right = self._sum()
            this = _COMPARE[sign](left, right).astype(np.int64)
            holds = this if holds is None else holds & this
            left = right
        return left if holds is None else holds

    def _sum(self) -> Values:
        value = self._product()
        while sign := self._take("+", "-"):
            other = self._product()
            value = self._small(value + other if sign == "+" else value - other)
        return value

    def _product(self) -> Values:
        value = self._factor()
        while sign := self._take("*", "%"):
            other = self._factor()
            if sign == "%" and (other == 0).any():
                raise InputError(f"rule {self.text!r}: a remainder after division by 0")
            value = self._small(value * other) if sign == "*" else value % other
        return value

    def _factor(self) -> Values:
        self.depth += 1
        if self.depth > _DEEPEST:
            raise InputError(f"rule {self.text!r}: brackets more than {_DEEPEST} deep")
        value = self._atom()
        self.depth -= 1
        return value

    def _atom(self) -> Values:
        if self._take("-"):
            return -self._factor()
        if self._take("("):
            value = self._or()
            if not self._take(")"):
                self._wrong("')'")
            return value
        token = self._next
        if token.isascii() and token.isdigit():
            if len(token) > 9:
                self._wrong(f"a number below {_LARGEST}")
            self.at += 1
            return np.full(1024, int(token))
        if token not in self.names:
            known = "" if token in _WORDS or not token[:1].isalpha() else f" (names are {', '.join(self.names)})"
            self._wrong(f"a cell, a number or a bracket{known}")
        self.at += 1
        return self.names[token]

    def _small(self, value: Values) -> Values:
        if np.abs(value).max() > _LARGEST:  # a further product would no longer fit in 64 bits
            raise InputError(f"rule {self.text!r}: a value beyond {_LARGEST}")
        return value


def _truth(value: Values) -> Values:
    return (value != 0).astype(np.int64)
