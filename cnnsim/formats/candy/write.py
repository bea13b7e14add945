"""Write templates of the library as ``.tem`` files: their numbers, and their setting as header comments."""

from cnnsim.formats.candy.content import Block, Call, FunctionLine, Header, Layer, MatrixEntry, Section, TemFile
from cnnsim.formats.candy.from_terms import template_section
from cnnsim.formats.numbers import written
from cnnsim.library.entry import LibraryEntry, Role
from cnnsim.network import Boundary, Cell
from cnnsim.support import InputError

_BOUNDARIES = {"zero-flux": "Zero-flux", "periodic": "Periodic"}


def write_tem(tem: TemFile) -> str:
    """Return the text of a file; reading it gives the same content again."""
    lines = [f"%{header.key}: {header.text}".rstrip() for header in tem.headers]
    lines += [f"%% {comment}" for comment in tem.comments]
    script = len(tem.sections) > 1 or tem.loop is not None
    for section in tem.sections:
        if script:
            lines += ["", *([f"LABEL {section.label}"] if section.label else [])]
            lines += [f"TEMPLATE: {section.title}".rstrip(), "NEW"]
        lines += _section(section)
    if tem.loop is not None:
        lines += ["", f"LOOP: {tem.loop[0]} {tem.loop[1]}"]
    return "\n".join(lines) + "\n"


def _section(section: Section) -> list[str]:
    several = len(section.layers) > 1
    lines = ["", f"NRLAYERS {len(section.layers)}"] if several else []
    radius: int | None = None
    for layer in section.layers:
        if several:
            lines += ["", f"LAYER {layer.number} {layer.label}".rstrip()]
        delay: float | None = None
        for block in layer.blocks:
            if block.radius is not None and block.radius != radius:
                radius = block.radius
                lines += ["", f"NEIGHBORHOOD: {radius}"]
            if block.delay is not None and block.delay != delay:
                delay = block.delay
                lines += ["", f"DELAY: {written(delay)}"]
            lines += ["", *_block(block)]
        lines += _tail(layer)
    return lines


def _block(block: Block) -> list[str]:
    source = "" if block.source is None else f" FROM {block.source}"
    lines = [f"{block.operation.upper()}{source}:"]
    if block.operation == "nonlin_d":
        lines.append(f"{block.argument}#{block.factor}")
    cells = [[_entry(entry) for entry in row] for row in block.rows]
    width = max(len(cell) for row in cells for cell in row)
    return lines + [" ".join(cell.rjust(width) for cell in row) for row in cells]


def _entry(entry: MatrixEntry) -> str:
    return f"{entry.letter}{entry.of}" if isinstance(entry, Call) else written(entry)


def _tail(layer: Layer) -> list[str]:
    lines = ["", *map(_function, layer.functions)] if layer.functions else []
    return lines + ([] if layer.current is None else ["", f"CURRENT: {written(layer.current)}"])


def _function(function: FunctionLine) -> str:
    points = "  ".join(f"{written(x)} {written(y)}" for x, y in function.points)
    return f"{function.letter} {int(function.linear)} {len(function.points)}  {points}"


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
        raise InputError(f"a cell of its own ({cell.model}, output {cell.output}): a .tem file has no header for it")
    time = "CT-CNN" if cell == Cell() else "DT-CNN"
    layers = len(section.layers)
    delayed = any(block.delay is not None for layer in section.layers for block in layer.blocks)
    return f"{'Single-layer' if layers == 1 else f'Multi-layer({layers})'}, {time}{', Delayed' if delayed else ''}"


def _setting(entry: LibraryEntry) -> str:
    boundary, state = _boundary(entry.boundary), entry.initial_state
    if isinstance(state, tuple) or entry.frame_time is not None or entry.step is not None:
        raise InputError("initial states of layers, a sequence or a step of its own: a .tem file has no header for it")
    if state != "given":
        return f"Input:{_role(entry.input)}, IniState:{_role(state)}, Boundary:{boundary}"
    if entry.input != "picture":
        raise InputError(f"input {entry.input!r} with a second picture as state: a .tem file has no header for it")
    return f"Input:P1, IniState:P2, Boundary:{boundary}"


def _role(role: Role) -> str:
    words = {"picture": "P", "any": "Arbitrary(0)", "none": "-"}
    return words[role] if isinstance(role, str) else written(role)


def _boundary(boundary: Boundary) -> str:
    if boundary.kind != "fixed":
        if boundary.kind not in _BOUNDARIES:
            raise InputError(f"boundary {boundary}: a .tem file has no header for it")
        return _BOUNDARIES[boundary.kind]
    if boundary.y != boundary.u:
        raise InputError(f"boundary {boundary}: a .tem file has one value for state and input")
    return f"Fixed({written(boundary.y)})"
