"""Writes ``.tem`` files from their content."""

from cnnsim.formats.candy.content import Block, Call, FunctionLine, Layer, MatrixEntry, Section, TemFile
from cnnsim.support.numbers import written


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
