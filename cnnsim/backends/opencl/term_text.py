"""Terms as OpenCL text: taps, places and values as literals, a table as a chain of comparisons without a branch."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from cnnsim.backends.codes import NOTHING, FunctionCode
from cnnsim.backends.opencl.channel_text import ChannelText
from cnnsim.backends.opencl.device.build import Defines, literal
from cnnsim.backends.term_table import Function, TermTable

LONG = 20
"""Taps times places of their table from which on taps are a loop."""


def term_defines(
    terms: TermTable, channels: ChannelText, layers: int, output: Function | None, dtype: np.dtype[Any]
) -> Defines:
    """Return the definitions of terms.cl: the terms of each layer, and the characteristic.

    ``channels`` says how they are read. CASES(DO) names the layers by number, TERMS_n adds the terms of layer n to
    ``total``. OUTPUT(T) is the ``output`` characteristic, CHARACTERISTIC its code; TABLES is what stands outside all
    functions.
    """
    texts, tables = [""] * layers, ""
    for number, link in enumerate(np.stack(terms.terms, axis=1).tolist()):
        text, table = _term(terms, channels, link, str(number), dtype)
        texts[link[0]] += text
        tables += table
    return {
        "CASES(DO)": " ".join(f"DO({number})" for number in range(layers)),
        **{f"TERMS_{number}": text for number, text in enumerate(texts)},
        "TABLES": tables,
        "LAYERS": layers,
        "CHARACTERISTIC": NOTHING if output is None else int(output.kind),
        "OUTPUT(T)": "" if output is None else _function(output[:4], output.numbers, "T", dtype),
    }


def _term(terms: TermTable, seen: ChannelText, link: list[int], name: str, dtype: np.dtype[Any]) -> tuple[str, str]:
    """Return the statements that add a term to ``total``, and the tables they read.

    Taps of short terms are written one by one, those of long ones as a loop: a compiler needs seconds for hundreds.
    """
    _, of, centre, times, times_centre, first, after, *function = link
    text = "" if centre == NOTHING else f"const vec here{name} = {seen.read(centre)}; "
    text += "" if times_centre == NOTHING else f"const vec factor{name} = {seen.read(times_centre)}; "
    applied = _function(function, terms.numbers, "vec", dtype)

    def tap(k: Any, l: Any, weight: str) -> str:
        less = "" if centre == NOTHING else f" - here{name}"
        body = f"{{ const vec v = {seen.read(of, k, l)}{less}; vec f = v; {applied}"
        if times != NOTHING:
            less = "" if times_centre == NOTHING else f" - factor{name}"
            body += f"f *= {seen.read(times, k, l)}{less}; "
        return body + f"total += {weight} * f; }} "

    offsets = np.stack([terms.taps.k, terms.taps.l, terms.taps.plane], axis=1)[first:after].tolist()
    taps, weights = offsets, [literal(c, dtype) for c in terms.taps.weight[first:after]]
    if len(taps) == 1 or len(taps) * (1 + function[1]) <= LONG:
        for (k, l, plane), weight in zip(taps, weights, strict=True):
            text += tap(k, l, f"(vec){weight}" if plane == NOTHING else f"WEIGHT({plane})")
        return text, ""
    weight = f"(vec)weight{name}[tap]" if taps[0][2] == NOTHING else f"WEIGHT(tap + {taps[0][2]})"
    text += f"for (int tap = 0; tap < {len(taps)}; tap++) " + tap(f"place{name}[tap].x", f"place{name}[tap].y", weight)
    places = ", ".join(f"{{{k}, {l}}}" for k, l, _ in taps)
    return text, (
        f"__constant int2 place{name}[] = {{{places}}}; __constant real weight{name}[] = {{{', '.join(weights)}}}; "
    )


def _function(links: Sequence[int], numbers: np.ndarray[Any, Any], type_: str, dtype: np.dtype[Any]) -> str:
    """Return the statements that set f to a function of v; see `term_table.Function`."""
    kind, places, at, values = links

    def splat(value: Any) -> str:
        return f"({type_}){literal(value, dtype)}"

    if kind == FunctionCode.IDENTITY:
        return ""
    if kind == FunctionCode.CLIP:
        return f"f = v * {splat(numbers[at])}; f = CLIP({type_}, f); "
    if kind == FunctionCode.SIGN:
        return f"f = v > ({type_})0 ? ({type_})1 : v < ({type_})0 ? ({type_})-1 : v; "
    if kind not in (FunctionCode.LINEAR, FunctionCode.STEP):
        return f"f = v * {splat(numbers[at])}; TANH({type_}, f) "
    e, f = numbers[at : at + places], numbers[values : values + places + (kind == FunctionCode.STEP)]
    text = f"f = {splat(f[0])}; "
    for s in range(places):
        beyond = splat(f[-1] if kind == FunctionCode.LINEAR else f[s + 1])
        if kind == FunctionCode.LINEAR and s + 1 < places:
            rise = (f[s + 1] - f[s]) / (e[s + 1] - e[s])
            beyond = f"{splat(f[s])} + {splat(rise)} * (v - {splat(e[s])})"
        text += f"f = v > {splat(e[s])} ? {beyond} : f; "
    return text
