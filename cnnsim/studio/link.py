"""Links: a setup as the text after # of an address, and back."""

import base64
import json
import re
import zlib
from dataclasses import replace
from typing import Any

from cnnsim.library.write import template_keys
from cnnsim.studio.colours import indices, values
from cnnsim.studio.setup import Setup, boundary_text, changed, first_setup
from cnnsim.support import InputError
from cnnsim.support.errors import shown

MOST_LINKED = 2**20
"""Bytes of a plane or a network in a link."""
_WORDS = {"start": "initial_state", "time": "duration", "step": "step", "accuracy": "accuracy"}


def link_of(setup: Setup) -> str:
    """Return the link of a setup: what differs from the template's own file, and the picture."""
    now, own = setup.entry, setup.own
    parts: dict[str, Any] = {"template": now.name, "size": f"{setup.grid[0]}x{setup.grid[1]}"}
    if setup.made is not None:
        parts |= {"picture": setup.made[0].replace(" ", "-"), "seed": setup.made[1]}
    else:
        parts["drawn"] = _packed(indices(setup.picture).tobytes())
    if now.initial_state != own.initial_state:
        parts["start"] = now.initial_state
    if setup.takes_second and setup.second is not None:
        parts["second"] = _packed(indices(setup.second).tobytes())
    if now.boundary != own.boundary:
        parts["boundary"] = boundary_text(now.boundary)
    if now.cell != own.cell:
        parts["cell"] = now.cell.model
    if now.duration != own.duration:
        parts["time"] = now.duration
    if setup.scheme:
        parts["scheme"] = setup.scheme
    for key in ("step", "accuracy"):
        if (value := getattr(now, key)) != getattr(own, key):
            parts[key] = "none" if value is None else value
    if setup.backend != "cpu":
        parts["backend"] = setup.backend
    if setup.changed:
        parts["weights"] = _packed(json.dumps(template_keys(now.network)).encode())
    return "&".join(f"{key}={value}" for key, value in parts.items())


def read_link(text: str) -> Setup:
    """Return the setup of a link.

    Raises:
        InputError: a part of the link is wrong.
    """
    parts = dict(part.partition("=")[::2] for part in text.lstrip("#").split("&") if part)
    size = re.fullmatch(r"(\d{1,4})x(\d{1,4})", parts.get("size", "64x64"))
    seed = re.fullmatch(r"\d{1,9}", parts.get("seed", "0"))
    name = parts.get("template", "hole-filler")
    if size is None or seed is None or not re.fullmatch(r"[\w-]+", name):
        raise InputError(f"link {shown(text)}; template=NAME&size=ROWSxCOLS&picture=NAME&seed=NUMBER wanted")
    grid = int(size[1]), int(size[2])
    setup = first_setup(name, grid, parts.get("picture", "curves").replace("-", " "), int(seed[0]))
    if "drawn" in parts:
        setup = setup.with_picture(values(_unpacked(parts["drawn"]), setup.picture.shape))
    if "second" in parts:
        setup = replace(setup, second=values(_unpacked(parts["second"]), grid))
    changes: dict[str, Any] = {key: parts[key] for key in ("boundary", "cell", "scheme", "backend") if key in parts}
    changes |= {new: _number_or_word(parts[key]) for key, new in _WORDS.items() if key in parts}
    if "weights" in parts:
        try:
            changes["network"] = json.loads(_unpacked(parts["weights"]))
        except ValueError as error:
            raise InputError("link: weights that are no JSON") from error
    return changed(setup, changes)


def _packed(data: bytes) -> str:
    return base64.urlsafe_b64encode(zlib.compress(data)).decode().rstrip("=")


def _unpacked(text: str) -> bytes:
    try:
        reader = zlib.decompressobj()
        data = reader.decompress(base64.urlsafe_b64decode(text + "=" * (-len(text) % 4)), MOST_LINKED)
    except (ValueError, zlib.error) as error:
        raise InputError(f"link: {shown(text)} holds no packed bytes") from error
    if reader.unconsumed_tail:
        raise InputError(f"link: more than {MOST_LINKED} bytes in {shown(text)}")
    return data


def _number_or_word(text: str) -> float | str | None:
    if text == "none":
        return None
    try:
        return float(text)
    except ValueError:
        return text
