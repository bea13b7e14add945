"""Terms as OpenCL text: taps and tables as literals, a table as a chain of comparisons without a branch."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from cnnsim.backends.codes import NOTHING, FunctionCode
from cnnsim.backends.opencl.device.build import Defines, literal
from cnnsim.backends.term_table import Function, TermTable

LONG = 20
"""Taps times places of their table from which on taps are a loop: a compiler needs seconds for hundreds of taps."""


def term_defines(
    table: TermTable, layers: int, output: Function | None, delays: Sequence[int], dtype: np.dtype[Any]
) -> Defines:
    """Return the definitions of terms.cl: the terms of each layer, and the output characteristic.

    CASES(DO) names the layers by number, TERMS_n adds the terms of layer n to ``total``, OUTPUT is the ``output``
    characteristic and CHARACTERISTIC its code; without it outputs are states. TABLES stands outside all functions.
    ``delays`` [steps] are those of the input's planes, in their order.
    """
    texts, tables = [""] * layers, ""
    for number, link in enumerate(np.stack(table.terms, axis=1).tolist()):
        text, constants = _Text(table, delays, dtype).term(link, str(number))
        texts[link[0]] += text
        tables += constants
    return {
        "CASES(DO)": " ".join(f"DO({number})" for number in range(layers)),
        **{f"TERMS_{number}": text for number, text in enumerate(texts)},
        "TABLES": tables,
        "LAYERS": layers,
        "CHARACTERISTIC": NOTHING if output is None else int(output.kind),
        "OUTPUT": "" if output is None else _function(output[:4], output.numbers, dtype),
    }


class _Text:
    def __init__(self, table: TermTable, delays: Sequence[int], dtype: np.dtype[Any]) -> None:
        self._table, self._delays, self._dtype = table, delays, dtype

    def _read(self, channel: int, k: object = 0, l: object = 0) -> str:
        quantity, layer, ago = self._table.channels[channel]
        plane = self._delays.index(ago) if quantity == "u" else ago
        return f"READ_{quantity}({plane}, {layer}, {k}, {l})"

    def term(self, link: list[int], name: str) -> tuple[str, str]:
        """Return the statements that add a term to ``total``, and the tables that they read."""
        _, of, centre, times, times_centre, first, after, *function = link
        dtype, taps = self._dtype, self._table.taps
        text = "" if centre == NOTHING else f"const vec here{name} = {self._read(centre)}; "
        text += "" if times_centre == NOTHING else f"const vec factor{name} = {self._read(times_centre)}; "
        applied = _function(function, self._table.numbers, dtype)

        def tap(k: Any, l: Any, weight: str) -> str:
            less = "" if centre == NOTHING else f" - here{name}"
            body = f"{{ const vec v = {self._read(of, k, l)}{less}; vec f = v; {applied}"
            if times != NOTHING:
                less = "" if times_centre == NOTHING else f" - factor{name}"
                body += f"f *= {self._read(times, k, l)}{less}; "
            return body + f"total += {weight} * f; }} "

        places = np.stack([taps.k, taps.l, taps.plane], axis=1)[first:after].tolist()
        weights = [literal(c, dtype) for c in taps.weight[first:after]]
        if len(places) == 1 or len(places) * (1 + function[1]) <= LONG:
            for (k, l, plane), weight in zip(places, weights, strict=True):
                text += tap(k, l, f"(vec){weight}" if plane == NOTHING else f"WEIGHT({plane})")
            return text, ""
        weight = f"(vec)weight{name}[tap]" if places[0][2] == NOTHING else f"WEIGHT(tap + {places[0][2]})"
        each = tap(f"place{name}[tap].x", f"place{name}[tap].y", weight)
        offsets = ", ".join(f"{{{k}, {l}}}" for k, l, _ in places)
        return f"{text}for (int tap = 0; tap < {len(places)}; tap++) {each}", (
            f"__constant int2 place{name}[] = {{{offsets}}}; "
            f"__constant real weight{name}[] = {{{', '.join(weights)}}}; "
        )


def _function(links: Sequence[int], numbers: np.ndarray[Any, Any], dtype: np.dtype[Any]) -> str:
    """Return the statements that set f to a function of v; see `term_table.Function`."""
    kind, places, at, values = links

    def splat(value: Any) -> str:
        return f"(vec){literal(value, dtype)}"

    if kind == FunctionCode.IDENTITY:
        return ""
    if kind == FunctionCode.CLIP:
        return f"f = v * {splat(numbers[at])}; f = CLIP(vec, f); "
    if kind == FunctionCode.SIGN:
        return "f = v > (vec)0 ? (vec)1 : v < (vec)0 ? (vec)-1 : v; "
    if kind not in (FunctionCode.LINEAR, FunctionCode.STEP):
        return f"f = tanh_of(v * {splat(numbers[at])}); "
    e, f = numbers[at : at + places], numbers[values : values + places + (kind == FunctionCode.STEP)]
    text = f"f = {splat(f[0])}; "
    for s in range(places):
        beyond = splat(f[-1] if kind == FunctionCode.LINEAR else f[s + 1])
        if kind == FunctionCode.LINEAR and s + 1 < places:
            rise = (f[s + 1] - f[s]) / (e[s + 1] - e[s])
            beyond = f"{splat(f[s])} + {splat(rise)} * (v - {splat(e[s])})"
        text += f"f = v > {splat(e[s])} ? {beyond} : f; "
    return text
