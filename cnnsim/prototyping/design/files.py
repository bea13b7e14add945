"""Writes designs: each template as a file with its own worked examples, several as a program that joins them."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from cnnsim.library.entry import Example, LibraryEntry
from cnnsim.library.write import template_text, toml_value
from cnnsim.network import Boundary
from cnnsim.network.boundary import boundary_value
from cnnsim.prototyping.design.design import Design, DesignPart
from cnnsim.prototyping.design.rule import WindowRule
from cnnsim.support import Floats
from cnnsim.support.command_files import check_free
from cnnsim.support.files import write_text


def part_names(design: Design, name: str) -> list[str]:
    """Return the names of a design's templates: the design's own, or numbered."""
    return [name] if len(design.parts) == 1 else [f"{name}-{i}" for i in range(1, len(design.parts) + 1)]


def write_design(
    design: Design, name: str, boundary: Boundary, folder: Path, pictures: Sequence[Floats] = (), *,
    replace: bool = False,
) -> list[Path]:  # fmt: skip
    """Write the template files and, of more than a single template, the program under ``programs``; return their paths.

    ``pictures`` are worked examples; without any, random ones are taken whose windows the rule all knows.

    Raises:
        InputError: a file is there and not to be replaced (then none is written), or the folder cannot be written.
    """
    tables = [design.rule.table] if design.one_template else design.outputs()
    names = part_names(design, name)
    texts = {
        f"{part_name}.toml": _part_text(design, number, part_name, tables, boundary, pictures)
        for number, part_name in enumerate(names)
    }
    if not design.one_template:
        texts[f"programs/{name}.toml"] = program_text(design, name, boundary)
    paths = [folder / file for file in texts]
    check_free(*paths, replace=replace)
    for path, text in zip(paths, texts.values(), strict=True):
        write_text(path, text, replace=replace, follow=False)
    return paths


def program_text(design: Design, name: str, boundary: Boundary) -> str:
    """Return the program that runs a design's templates and joins their outputs."""
    names = part_names(design, name)
    planes = [f"part_{number}" for number in range(1, len(names) + 1)]
    inputs = ["picture", "state"] if design.rule.with_state else ["picture"]
    lines = [
        f"name = {toml_value(name)}",
        f"summary = {toml_value(f'{design.rule.text}: {len(names)} templates, joined by {design.join}.')}",
        f"llm = {toml_value([*inputs, *planes, 'turned', 'result'])}",
        f"inputs = {toml_value(inputs)}",
        'outputs = ["result"]',
    ]
    for part, part_name in zip(design.parts, names, strict=True):
        t = part.template(part_name)
        data = {"A": t.A.tolist(), "B": t.B.tolist(), "z": t.z, "boundary": boundary_value(boundary)}
        lines += ["", f"[templates.{part_name}]", *(f"{key} = {toml_value(value)}" for key, value in data.items())]
    for number, (part, part_name) in enumerate(zip(design.parts, names, strict=True)):
        states: dict[str, str | float] = {"none": 0, "state": "state", "last": planes[number - 1]}
        state = states[part.state]
        if part.negated:
            lines += _step(logic="not-p", of=[state], to="turned")
            state = "turned"
        lines += _step(template=part_name, input="picture", state=state, to=planes[number])
    lines += _step(copy=planes[-1] if design.join == "last" else planes[design.first], to="result")
    if design.join != "last":
        for plane in planes[design.first + 1 :]:
            lines += _step(logic=design.join, of=["result", plane], to="result")
    return "\n".join(lines) + "\n"


def _step(**entries: Any) -> list[str]:
    return ["", "[[step]]", *(f"{key} = {toml_value(value)}" for key, value in entries.items())]


def _part_text(
    design: Design, number: int, name: str, tables: list[Any], boundary: Boundary, pictures: Sequence[Floats]
) -> str:
    part, rule = design.parts[number], design.rule
    whole = WindowRule(tables[number], rule.text)
    found = []
    for picture, state in _pictures(whole, boundary, pictures):
        start = state
        if part.state == "last":
            start = WindowRule(tables[number - 1], rule.text).answer(picture, boundary, state)
        if start is not None and part.negated:
            start = -start
        shown = None if part.state == "none" else start
        found.append(Example(picture, shown, whole.answer(picture, boundary, state)))
    step = f"Step {number + 1} of {len(tables)} of: {rule.text}."
    summary = f"Black where {rule.text}." if design.one_template else step
    return template_text(LibraryEntry(
        name, summary, _reference(part), part.template(name), boundary=boundary, examples=tuple(found), margin=1,
        initial_state="any" if part.state == "none" else "given", tags=("designed", "uncoupled", "binary"),
        note="" if part.state == "none" else f"The initial state is {_state_words(part)}.",
    ))  # fmt: skip


def _pictures(rule: WindowRule, boundary: Boundary, given: Sequence[Floats]) -> list[tuple[Floats, Floats | None]]:
    """Return up to three pictures (and states) all of whose windows the rule knows, the user's own first."""
    rng, found = np.random.default_rng(0), []
    tries = [*given, *(np.where(rng.random((9, 10)) < share, 1.0, -1.0) for share in [0.2, 0.5, 0.8] * 20)]
    for number, picture in enumerate(tries):
        state = np.where(rng.random(picture.shape) < 0.5, 1.0, -1.0) if rule.with_state else None
        answer = rule.answer(picture, boundary, state)
        if answer.all() and (number < len(given) or abs(answer.mean()) < 1):
            found.append((picture, state))
        if len(found) == max(2, len(given)):
            break
    if not found:
        picture = tries[-1]
        found.append((picture, np.ones(picture.shape) if rule.with_state else None))
    return found


def _reference(part: DesignPart) -> str:
    size = sum(abs(float(weight)) for weight in (*part.separator.weights, part.separator.bias))
    return (
        "Designed from its rule by linear programming for the largest margin: 1, where |B|, |z| and a - 1 sum to "
        f"{size:.4g}"
    )


def _state_words(part: DesignPart) -> str:
    plane = {"state": "the second picture", "last": "the output of the step before", "none": ""}[part.state]
    return f"the negative of {plane}" if part.negated else plane
