"""LayeredTemplate: a network of several layers of cells, each with its template and time constant."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from cnnsim.network.template import Template
from cnnsim.support import InputError
from cnnsim.support.keywords import spelled
from cnnsim.support.values import is_number


@dataclass(frozen=True, eq=False, repr=False)
class LayeredTemplate:
    """The template of a network of layers: T_l dx_l/dt = -x_l + A_l*y_l + B_l*u_l + z_l + terms of layer l.

    ``layers`` has a template per layer; a term with ``layer`` set couples layers. ``time_constants`` T_l are in time
    constants of the network (1 if not given). A plane of the network is (layers, rows, cols), a batch (n, layers, rows,
    cols).

    Raises:
        InputError: no layer, time constants that are not positive or not one per layer, a term that reads a
            layer that does not exist.
    """

    layers: tuple[Template, ...]
    time_constants: tuple[float, ...]
    name: str = "unnamed"

    @spelled()
    def __init__(
        self, layers: Sequence[Template], time_constants: Sequence[float] | None = None, name: str = "unnamed"
    ) -> None:
        if not isinstance(layers, Iterable) or not isinstance(time_constants, Iterable | None):
            raise InputError(f"template {name!r}: layers {layers!r}, time constants {time_constants!r}; lists wanted")
        object.__setattr__(self, "layers", tuple(layers))
        times = (1.0,) * len(self.layers) if time_constants is None else tuple(time_constants)
        object.__setattr__(self, "name", name)
        if not all(map(is_number, times)):
            raise InputError(f"template {name!r}: time constants {times}; positive numbers wanted")
        times = tuple(map(float, times))
        object.__setattr__(self, "time_constants", times)
        if not self.layers or not all(isinstance(layer, Template) for layer in self.layers):
            raise InputError(f"template {name!r} has layers {self.layers!r}; one Template or more wanted")
        if len(times) != len(self.layers) or not all(0 < time < np.inf for time in times):
            raise InputError(f"template {name!r}: time constants {times}; {len(self.layers)} positive numbers wanted")
        for number, layer in enumerate(self.layers):
            for term in layer.terms:
                if term.layer is not None and term.layer >= len(self.layers):
                    raise InputError(
                        f"template {name!r}: a term of layer {number} reads layer {term.layer}; 0 to "
                        f"{len(self.layers) - 1} are there"
                    )

    def __repr__(self) -> str:
        times = "" if set(self.time_constants) == {1.0} else f", time constants {self.time_constants}"
        return f"LayeredTemplate({self.name!r}, {len(self.layers)} layers: {list(self.layers)}{times})"

    def _repr_html_(self) -> str:
        from cnnsim.plot.html import heading

        pairs = zip(self.time_constants, self.layers, strict=True)
        layers = (
            f"<div>layer {n}, time constant {t:g}</div>{layer._repr_html_()}" for n, (t, layer) in enumerate(pairs)
        )
        return heading("LayeredTemplate", f"{self.name}, {len(self.layers)} layers") + "".join(layers)

    @property
    def reads_input(self) -> bool:
        """Whether a layer reads its input."""
        return any(layer.reads_input for layer in self.layers)

    @property
    def uncoupled(self) -> bool:
        """Whether no cell is coupled to another cell of any layer."""
        return all(layer.uncoupled for layer in self.layers)

    @property
    def radius(self) -> int:
        """The largest radius of its layers."""
        return max(layer.radius for layer in self.layers)

    def state_bound(self, bias: float = 0.0) -> float:
        """Return the largest of the layers' bounds, see `Template.state_bound`."""
        return max(layer.state_bound(bias) for layer in self.layers)


AnyTemplate = Template | LayeredTemplate


def layered(template: AnyTemplate) -> LayeredTemplate:
    """Return a template as a LayeredTemplate; a plain one becomes a single layer.

    Raises:
        InputError: a plain template with a term that reads another layer.
    """
    return template if isinstance(template, LayeredTemplate) else LayeredTemplate((template,), None, template.name)


def check_template(template: object) -> None:
    """Check that an argument is a template.

    Raises:
        InputError: it is not, such as the name of a template.
    """
    if not isinstance(template, Template | LayeredTemplate):
        cure = f"; of the library: cnnsim.library.load({template!r}).template" if isinstance(template, str) else ""
        raise InputError(f"template {template!r}; a Template or LayeredTemplate wanted{cure}")
