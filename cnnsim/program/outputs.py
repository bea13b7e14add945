"""Outputs of a program: a dictionary that a notebook shows as a strip of pictures."""

from typing import Any

import numpy as np

from cnnsim.support.values import is_stored


class ProgramOutputs(dict[str, Any]):
    """Outputs by name: arrays (rows, cols), logic planes as booleans; numbers from wires."""

    def _repr_html_(self) -> str:
        from cnnsim.plot.html import facts, heading, image  # used by notebooks only
        from cnnsim.support.pictures.picture import to_png  # the same

        cells, numbers = [], {}
        for name, value in self.items():
            if is_stored(value) or np.ndim(value) < 2:
                numbers[name] = value
                continue
            plane = np.where(value, 1.0, -1.0) if value.dtype == bool else value
            cells.append(f'<td style="padding-right:12px">{heading(name)}{image(to_png(plane))}</td>')
        return (f"<table><tr>{''.join(cells)}</tr></table>" if cells else "") + (facts(numbers) if numbers else "")
