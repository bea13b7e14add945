"""Writing a choice of effects as a scene file, with its accuracy and a table for each chosen effect."""

import re
from pathlib import Path
from typing import Any

from cnnsim.library.write import toml_value
from cnnsim.support import InputError
from cnnsim.support.files import write_text
from cnnsim.support.toml_file import parse_toml
from tactile.simulator.auto_effects import Choice

_HEADER = re.compile(r"\s*\[+\s*[\"'\w]")
"""A line that begins a table; rows of numbers begin with a digit, a sign or a bracket."""


def write_choice(path: Path, table: dict[str, Any], choice: Choice | None, write: Path) -> None:
    """Write the scene file at ``path``, parsed as ``table``, with the choice instead of "auto".

    Comments and all other tables stay as they are.

    Raises:
        InputError: ``choice`` is None; ``write`` is the scene itself; the scene reads files of its folder and ``write``
            lies in another one; effects written in a way that cannot be taken out line by line.
    """
    if choice is None:
        raise InputError(f"{path}: nothing to keep; a scene with effects = 'auto' wanted")
    if write.resolve() == path.resolve():
        raise InputError(f"{write}: the name of the scene itself; another name wanted")
    files = table.get("map") or any("file" in contact for contact in table.get("contact", []))
    if files and write.resolve().parent != path.resolve().parent:
        raise InputError(f"{write}: {path} reads files of its folder; a file in the same folder wanted")
    lines: list[str] = []
    skipping = False
    for line in path.read_text(encoding="utf-8").splitlines():
        if _HEADER.match(line):
            skipping = re.match(r"\s*\[\s*effect\s*[.\]]", line) is not None
        at_top = not any(map(_HEADER.match, lines))
        key = re.match(r"\s*(effects|tolerance|accuracy)\s*=", line) if at_top else None
        if key and key[1] == "effects":
            lines.append(f"accuracy = {toml_value(choice.scene.accuracy)}")
        elif not skipping and not key:
            lines.append(line)
    out = "; ".join(f"{name} {size:.2g}" for name, size in choice.left_out.items()) or "none"
    lines += [
        "",
        f"# Effects chosen for a tolerance of {choice.tolerance:g} of the peak, error at most {choice.bound:.2g}.",
    ]
    lines.append(f"# Left out, with what each would change: {out}.")
    for name, effect in choice.scene.effects:
        lines += ["", f"[effect.{name}]"]
        for key, (attribute, factor) in effect.KEYS.items():
            value = getattr(effect, attribute)
            if value is not None:
                lines.append(f"{key} = {toml_value(value / factor if isinstance(value, float) else value)}")
    text = "\n".join(lines) + "\n"
    chosen = ("effects", "tolerance", "accuracy", "effect")

    def rest(whole: dict[str, Any]) -> dict[str, Any]:
        return {key: value for key, value in whole.items() if key not in chosen}

    try:
        same = rest(parse_toml(text, str(write))) == rest(table)
    except InputError:
        same = False
    if not same:
        raise InputError(f"{path}: effects that are no tables of their own; [effect.NAME] wanted")
    write_text(write, text)
