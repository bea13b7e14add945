"""Gather the statements of a ``.tem`` file into layers and sections; report duplicate, missing and unknown ones."""

from dataclasses import dataclass, field, replace

from cnnsim.formats.candy.content import Block, Call, FunctionLine, Layer, Section
from cnnsim.formats.candy.lines import Line
from cnnsim.support import Diagnostics


@dataclass
class LayerBuilder:
    """A layer while it is read."""

    report: Diagnostics
    number: int = 1
    label: str = ""
    line: int = 0
    blocks: list[Block] = field(default_factory=list)
    functions: list[FunctionLine] = field(default_factory=list)
    current: float | None = None
    delay: float | None = None

    @property
    def has_content(self) -> bool:
        """Whether there is any statement."""
        return bool(self.blocks or self.functions) or self.current is not None

    def set_current(self, value: float | None, line: int) -> None:
        """Set z; a second, different one is an error."""
        if self.current is not None and value != self.current:
            self.report.error(line, f"a second CURRENT {value} in this layer, after {self.current}")
        self.current = value if self.current is None else self.current

    def set_delay(self, value: float | None, line: int) -> None:
        """Set the delay of the delayed blocks that follow."""
        if value is not None and value < 0:
            self.report.error(line, f"DELAY {value}; 0 or more wanted")
        self.delay = value

    def add_function(self, function: FunctionLine) -> None:
        """Add a function line; a second, different one of the same letter is an error."""
        same = [other for other in self.functions if other.letter == function.letter]
        if same and same[0] != function:
            self.report.error(function.line, f"function {function.letter!r} differs from that of line {same[0].line}")
        if not same:
            self.functions.append(function)

    def add_block(self, block: Block) -> None:
        """Add a matrix; a second one of the same kind and source is kept and reported."""
        if block.operation.startswith("delayed"):
            block = replace(block, delay=self.delay)
        for other in self.blocks:
            if (other.operation, other.source, other.delay) == (block.operation, block.source, block.delay):
                source = "" if block.source is None else f" FROM {block.source}"
                self.report.warning(
                    block.line, f"{block.operation.upper()}{source} again after line {other.line}; it is not known "
                    "whether the second replaces the first or adds to it",
                )  # fmt: skip
                break
        self.blocks.append(block)

    def finish(self, elsewhere: list[FunctionLine]) -> Layer:
        """Return the layer; functions that only other layers define are taken from these, with a warning."""
        for block in self.blocks:
            for letter in _letters(block):
                if all(function.letter != letter for function in self.functions):
                    self._borrow(letter, block, elsewhere)
        late = [block for block in self.blocks if block.operation.startswith("delayed") and block.delay is None]
        if late and self.delay is None:
            self.report.error(late[0].line, f"{late[0].operation.upper()} without a DELAY")
        elif late:
            self.report.warning(late[0].line, f"the DELAY {self.delay:g} stands after its block")
            self.blocks = [replace(block, delay=self.delay) if block in late else block for block in self.blocks]
        if self.current is None and self.has_content:
            self.report.note(self.line or None, "no CURRENT: z = 0")
        used = {letter for block in self.blocks for letter in _letters(block)}
        for function in self.functions:
            if function.letter not in used:
                self.report.warning(function.line, f"function {function.letter!r} is not used")
        return Layer(self.number, tuple(self.blocks), tuple(self.functions), self.current, self.label, self.line)

    def _borrow(self, letter: str, block: Block, elsewhere: list[FunctionLine]) -> None:
        found = [function for function in elsewhere if function.letter == letter]
        if found:
            self.report.warning(block.line, f"function {letter!r} of another layer is used, line {found[0].line}")
            self.functions.append(found[0])
        else:
            self.report.error(block.line, f"{block.operation.upper()} names a function {letter!r} that has no line")


def _letters(block: Block) -> list[str]:
    return list(dict.fromkeys(entry.letter for row in block.rows for entry in row if isinstance(entry, Call)))


@dataclass
class SectionBuilder:
    """A template while it is read: its layers, one without LAYER statements."""

    report: Diagnostics
    title: str = ""
    label: str = ""
    radius: int | None = None
    count: int | None = None
    layers: list[LayerBuilder] = field(default_factory=list)

    @property
    def layer(self) -> LayerBuilder:
        """The layer that is open."""
        if not self.layers:
            self.layers.append(LayerBuilder(self.report))
        return self.layers[-1]

    @property
    def has_content(self) -> bool:
        """Whether there is any statement."""
        return any(layer.has_content for layer in self.layers)

    def name(self, line: Line) -> None:
        """Take what follows TEMPLATE or LABEL."""
        self.title = line.rest if line.keyword == "TEMPLATE" else self.title
        self.label = line.rest if line.keyword == "LABEL" else self.label

    def announce(self, line: Line, count: int | None) -> None:
        """Take the number of layers."""
        if self.count is not None:
            self.report.error(line.number, "a second NRLAYERS")
        self.count = count

    def open_layer(self, number: int, label: str, line: int) -> None:
        """Begin a layer."""
        if self.layers and not self.layers[0].line:
            if self.layers[0].has_content:
                self.report.error(line, f"LAYER {number} after blocks that belong to no layer")
            self.layers.clear()
        if any(layer.number == number for layer in self.layers):
            self.report.error(line, f"LAYER {number} for the second time")
        self.layers.append(LayerBuilder(self.report, number, label, line))

    def finish(self) -> Section:
        """Return the section, its layers and their sources checked against NRLAYERS."""
        numbers = [layer.number for layer in self.layers]
        count = self.count if self.count is not None else len(numbers)
        if sorted(numbers) != list(range(1, count + 1)) and (self.count is not None or len(numbers) > 1):
            self.report.error(None, f"layers {numbers} found; 1 to {count} wanted")
        for layer in self.layers:
            for block in layer.blocks:
                if block.source is not None and block.source not in numbers:
                    self.report.error(block.line, f"FROM {block.source}: there is no such layer")
        everything = [function for layer in self.layers for function in layer.functions]
        return Section(tuple(layer.finish(everything) for layer in self.layers), self.title, self.label)
