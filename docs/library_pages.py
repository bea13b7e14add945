"""Pages of the library: one for each template and program, made from its file and its first worked example."""

from collections.abc import Iterable
from pathlib import Path
from urllib.parse import quote

import numpy as np
from PIL import Image

from cnnsim import LayeredTemplate, Template, library, load_program
from cnnsim.library.entry import Example, LibraryEntry
from cnnsim.program.numbering import step_rows
from cnnsim.program.program import Program
from cnnsim.support import Array
from tactile.events.detector_file import SHIPPED, shipped_detectors

SIDE = 168
"""Side of a picture on a page [pixels]."""


def write_library(folder: Path) -> None:
    """Write a page for each template and program into ``folder``, and an index with all of them."""
    (folder / "programs").mkdir(parents=True)
    entries = [library.load(name) for name in library.names()]
    for entry in entries:
        (folder / f"{entry.name}.md").write_text(_template_page(entry, folder), encoding="utf-8")
    programs = [load_program(str(path)) for path in sorted((library.folder() / "programs").glob("*.toml"))]
    programs += [detector.program for detector in shipped_detectors(SHIPPED)]
    for program in programs:
        (folder / "programs" / f"{program.name}.md").write_text(_program_page(program), encoding="utf-8")
    (folder / "index.md").write_text(_index(entries, programs), encoding="utf-8")


def _index(entries: list[LibraryEntry], programs: list[Program]) -> str:
    rows = "\n".join(f"| [{e.name}]({e.name}.md) | {e.summary} | {', '.join(e.tags)} |" for e in entries)
    listed = "\n".join(f"| [{p.name}](programs/{p.name}.md) | {p.summary} |" for p in programs)
    toctree = "\n".join([*(e.name for e in entries), *(f"programs/{p.name}" for p in programs)])
    return f"""# Library

{len(entries)} templates and {len(programs)} programs are shipped. Each template has worked
examples, which the tests run on every backend.

## Templates

| name | result | tags |
|---|---|---|
{rows}

## Programs

| name | result |
|---|---|
{listed}

```{{toctree}}
:hidden:

{toctree}
```
"""


def _template_page(entry: LibraryEntry, folder: Path) -> str:
    pictures = _pictures(entry.name, entry.examples[0], folder) if entry.examples else ""
    facts = [
        ("input u", entry.input), ("initial state x(0)", entry.initial_state), ("boundary", entry.boundary),
        ("running time", "until settled" if entry.duration == "settled" else f"{entry.duration:g} time constants"),
        ("guaranteed time on 64 x 64", entry.running_time((64, 64))),
        ("cell", entry.cell), ("margin", "not stated" if entry.margin is None else f"{entry.margin:g}"),
        ("tags", ", ".join(entry.tags)), ("other names", ", ".join(entry.aliases)), ("source", entry.reference),
    ]  # fmt: skip
    rows = "\n".join(f"| {name} | {_cell(value)} |" for name, value in facts if value not in ("", None))
    note = f"\n{entry.note}\n" if entry.note else ""
    second = ", state=second" if "given" in (entry.initial_state if isinstance(entry.initial_state, tuple)
                                             else (entry.initial_state,)) else ""  # fmt: skip
    return f"""# {entry.name}

{entry.summary}

{pictures}
## Template

{_matrices(entry.network)}

| property | value |
|---|---|
{rows}
{note}
## Use

```sh
cnnsim run {entry.name} picture.png -o result.png{" --state second.png" if second else ""}
cnnsim studio {quote(entry.name)}
```

```python
import cnnsim

result = cnnsim.run("{entry.name}", picture{second})
result.y
```
"""


def _pictures(name: str, example: Example, folder: Path) -> str:
    planes = {"input": example.input, "state": example.state, "output": example.output}
    found = []
    for role, plane in planes.items():
        if plane is None:
            continue
        flat = plane.reshape(-1, *plane.shape[-2:])  # the first and last of a sequence or of layers
        for number in sorted({0, len(flat) - 1}):
            file = f"{name}-{role}{number or ''}.png"
            _write(flat[number], folder / file)
            found.append((f"{role} {number}" if len(flat) > 1 else role, file))
    return f"""| {" | ".join(role for role, _ in found)} |
|{"---|" * len(found)}
| {" | ".join(f"![{name}: {role}]({file})" for role, file in found)} |
"""


def _write(plane: Array, path: Path) -> None:
    """Write a plane of CNN values as a grey picture with gaps between large cells."""
    scale = max(SIDE // max(plane.shape), 1)
    gray = np.kron(np.rint(127.5 * (1 - np.clip(plane, -1, 1))), np.ones((scale, scale)))
    if scale >= 6:
        gray[::scale], gray[:, ::scale] = 200, 200
    Image.fromarray(gray.astype(np.uint8)).save(path)


def _matrices(network: Template | LayeredTemplate) -> str:
    if isinstance(network, LayeredTemplate):
        return f"A network of {len(network.layers)} layers.\n\n```text\n{network}\n```"
    blocks = [rf"{name} = \begin{{pmatrix}}{_rows(matrix)}\end{{pmatrix}}"
              for name, matrix in (("A", network.A), ("B", network.B)) if np.any(matrix)]  # fmt: skip
    terms = "".join(f"\n- term: `{term}`" for term in network.terms)
    return rf"$${', quad '.join(blocks)}{', ' if blocks else ''}z = {network.z:g}$$".replace("quad", r"\quad") + terms


def _rows(matrix: Array) -> str:
    return r" \\ ".join(" & ".join(f"{value:g}" for value in row) for row in np.atleast_2d(matrix))


def _cell(value: object) -> str:
    return str(value).replace("|", r"\|").replace("\n", " ")


def _program_page(program: Program) -> str:
    steps = "\n".join(f"| {number} | {_cell(text)} | {to} |" for number, text, to in step_rows(program.steps))
    arguments = ", ".join(f"{plane}={plane}" for plane in program.inputs)
    return f"""# {program.name} (program)

{program.summary}

| property | value |
|---|---|
| inputs | {_listed(program.inputs)} |
| outputs | {_listed(program.outputs)} |
| source | {_cell(program.reference)} |

## Steps

| step | operation | writes |
|---|---|---|
{steps}

## Use

```python
import cnnsim

outputs = cnnsim.run_program("{program.name}", {arguments})
```
"""


def _listed(names: Iterable[str]) -> str:
    return ", ".join(f"`{name}`" for name in names)
