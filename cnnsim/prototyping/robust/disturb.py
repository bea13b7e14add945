"""Templates with the errors of a chip: relative errors of the entries, and entries of few bits."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from cnnsim.network import AnyTemplate, LayeredTemplate, Template
from cnnsim.support import Floats


def with_relative_errors(template: AnyTemplate, sigma: float, rng: np.random.Generator) -> AnyTemplate:
    """Return the template with every entry e of A, B, z and of the terms' weights replaced by e (1 + sigma N).

    N is standard normal. Entries that are zero stay zero: no weight is no error. The errors are those of one
    programming of a chip, the same in all its cells.
    """
    return _changed(template, lambda entries: entries * (1 + sigma * rng.standard_normal(entries.shape)))


def quantised(template: AnyTemplate, bits: int) -> AnyTemplate:
    """Return the template with entries in steps of R / (2**(bits - 1) - 1), R being the largest entry.

    So n bits hold a sign and n - 1 bits of size, zero and the largest entry are met exactly.
    """
    sizes: list[float] = []

    def measure(entries: Floats) -> Floats:
        sizes.append(float(np.abs(entries).max()))
        return entries

    _changed(template, measure)
    step = max(sizes) / (2 ** (bits - 1) - 1)
    return template if step == 0 else _changed(template, lambda entries: np.rint(entries / step) * step)


def _changed(template: AnyTemplate, change: Callable[[Floats], Any]) -> AnyTemplate:
    """Apply a change to all entries of a template, of all its layers."""
    if isinstance(template, LayeredTemplate):
        layers = [_changed_layer(layer, change) for layer in template.layers]
        return LayeredTemplate(layers, template.time_constants, template.name)
    return _changed_layer(template, change)


def _changed_layer(template: Template, change: Callable[[Floats], Any]) -> Template:
    a, b, z = change(template.A), change(template.B), float(change(np.asarray(template.z)))
    terms = [replace(term, weights=change(term.weights)) for term in template.terms]
    return Template(a, b, z, template.name, terms)
