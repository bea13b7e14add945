"""Keys of a scene file, known and required, and their check."""

from collections.abc import Mapping
from typing import Any

from cnnsim.support.error_list import ErrorList

TOP = (
    "title", "rate_hz", "duration_s", "seed", "effects", "tolerance", "accuracy",
    "cover", "finger", "load", "contact", "texture", "map", "effect",
)  # fmt: skip
COVER = ("youngs_modulus_mpa", "quantity", "full_scale", "kind")
BUMPS = ("diameter_mm", "thickness_mm", "contact_mm", "fillet_mm", "poissons_ratio", "strain", "indentation_mm")
TABLES: dict[str, tuple[tuple[str, ...], tuple[str, ...]]] = {
    "finger": (("name", "rows", "cols", "pitch_mm", "depth_mm", "origin_mm"),
               ("name", "rows", "cols", "pitch_mm", "depth_mm")),
    "load": (("finger", "path"), ("finger", "path")),
    "contact": (("finger", "shape", "radius_mm", "length_mm", "angle_deg", "friction", "given", "twist", "path",
                 "file", "pitch_mm", "unit_mm"),
                ("finger", "shape", "path")),
    "texture": (("finger", "material", "place_mm", "start_s", "stop_s", "speed_mm_s", "direction_deg", "force_N",
                 "stiffness_N_mm", "seed"), ("finger", "material", "stop_s", "speed_mm_s", "force_N")),
    "map": (("finger", "file", "pitch_mm", "origin_mm", "path"), ("finger", "file", "pitch_mm", "path")),
}  # fmt: skip
"""[[table]] -> its known keys and its required ones."""


def check_scene_keys(table: dict[str, Any], errors: ErrorList) -> None:
    """Add unknown and missing keys of all tables of a scene to the ``errors``."""
    errors.check(table, TOP, "", ("title", "rate_hz", "duration_s", "cover", "finger"))
    cover = table.get("cover")
    if isinstance(cover, Mapping):
        flat = cover.get("kind", "flat") == "flat"
        errors.check(cover, COVER if flat else (*COVER, *BUMPS), "[cover]", ("youngs_modulus_mpa",))
    for name, (known, needed) in TABLES.items():
        tables = table.get(name, [])
        for number, one in enumerate(tables if isinstance(tables, list) else [], 1):
            errors.check(one, known, f"{name} {number}", needed)
    effects = table.get("effect")
    if effects:
        from tactile.simulator.effects import ORDER, effect_class  # only where called for

        errors.check(effects, ORDER, "[effect]")
        for name in ORDER if isinstance(effects, Mapping) else ():
            if name in effects:
                errors.check(effects[name], tuple(effect_class(name).KEYS), f"[effect.{name}]")
