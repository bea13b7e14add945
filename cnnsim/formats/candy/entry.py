"""A template of our library as the content of a ``.tem`` file: its numbers, and its setting as header comments."""

from cnnsim.formats.candy.content import Header, Section, TemFile
from cnnsim.formats.candy.from_terms import template_section
from cnnsim.library.entry import LibraryEntry, Role
from cnnsim.network import Boundary, Cell
from cnnsim.support import InputError
from cnnsim.support.numbers import written

_BOUNDARIES = {"zero-flux": "Zero-flux", "periodic": "Periodic"}


def entry_to_tem(entry: LibraryEntry) -> TemFile:
    """Return the ``.tem`` content of a library template.

    Raises:
        InputError: a setting that the header comments have no word for, a kind of template that the blocks cannot say.
    """
    section = template_section(entry.network)
    headers = [
        Header("Function", " ".join(entry.summary.split())),
        Header("TemLibName", entry.name),
        Header("CNNModel", _model(section, entry.cell)),
        Header("Setting", _setting(entry)),
        Header("Timing", "-" if entry.duration == "settled" else f"{written(float(entry.duration))} tau"),
    ]
    comments = [" ".join(text.split()) for text in (f"Source {entry.reference}", entry.note) if text.strip()]
    return TemFile((section,), tuple(headers), tuple(comments))


def _model(section: Section, cell: Cell) -> str:
    if cell not in (Cell(), Cell("discrete-time")):
        raise InputError(f"a cell of its own ({cell.model}, output {cell.output}): no .tem header says that")
    time = "CT-CNN" if cell == Cell() else "DT-CNN"
    layers = len(section.layers)
    delayed = any(block.delay is not None for layer in section.layers for block in layer.blocks)
    return f"{'Single-layer' if layers == 1 else f'Multi-layer({layers})'}, {time}{', Delayed' if delayed else ''}"


def _setting(entry: LibraryEntry) -> str:
    boundary, state = _boundary(entry.boundary), entry.initial_state
    if isinstance(state, tuple) or entry.frame_time is not None or entry.step is not None:
        raise InputError("initial states of layers, a sequence or a step of its own: no .tem header says that")
    if state != "given":
        return f"Input:{_role(entry.input)}, IniState:{_role(state)}, Boundary:{boundary}"
    if entry.input != "picture":
        raise InputError(f"input {entry.input!r} with a second picture as initial state: no .tem header says that")
    return f"Input:P1, IniState:P2, Boundary:{boundary}"


def _role(role: Role) -> str:
    words = {"picture": "P", "any": "Arbitrary(0)", "none": "-"}
    return words[role] if isinstance(role, str) else written(role)


def _boundary(boundary: Boundary) -> str:
    if boundary.kind != "fixed":
        if boundary.kind not in _BOUNDARIES:
            raise InputError(f"boundary {boundary}: no .tem header says that")
        return _BOUNDARIES[boundary.kind]
    if boundary.y != boundary.u:
        raise InputError(f"boundary {boundary}: a .tem file has one value for state and input")
    return f"Fixed({written(boundary.y)})"
