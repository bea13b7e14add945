"""What a real chip does to a template: errors of its entries, coarse entries, noise."""

import numpy as np
from numpy.typing import NDArray

from cnnsim.template import Template


def with_relative_errors(template: Template, sigma: float, rng: np.random.Generator) -> Template:
    """Return the template with every entry e of A, B and z replaced by e (1 + sigma N), N standard normal.

    Entries that are zero stay zero: no weight is no error. The errors are those of one programming of a chip, the
    same in all its cells.
    """
    factors = 1 + sigma * rng.standard_normal(template.A.size + template.B.size + 1)
    a, b, z = np.split(factors, (template.A.size, template.A.size + template.B.size))
    return Template(
        template.A * a.reshape(template.A.shape),
        template.B * b.reshape(template.B.shape),
        template.z * float(z[0]),
        template.name,
    )


def quantised(template: Template, bits: int) -> Template:
    """Return the template with entries in steps of R / (2**(bits - 1) - 1), R being the largest entry.

    So n bits hold a sign and n - 1 bits of size, zero and the largest entry are met exactly.
    """
    largest = max(float(np.abs(template.A).max()), float(np.abs(template.B).max()), abs(template.z))
    step = largest / (2 ** (bits - 1) - 1)
    if step == 0:
        return template

    def rounded(entries: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.rint(entries / step) * step

    return Template(rounded(template.A), rounded(template.B), float(rounded(np.asarray(template.z))), template.name)
