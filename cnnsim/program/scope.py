"""Scope: what the steps of a program file can refer to, its names and its own templates."""

from collections.abc import Mapping
from dataclasses import dataclass

from cnnsim.network import Boundary, Template
from cnnsim.planning.duration import Duration
from cnnsim.program.names import Names

LocalTemplate = tuple[Template, Boundary, Duration]


@dataclass(frozen=True)
class Scope:
    """What a step can refer to."""

    names: Names
    templates: Mapping[str, LocalTemplate]
