"""Commands that list the input planes of detectors and the dictionary of sign codes."""

import click

from cnnsim.support.command_line import examples, print_json
from cnnsim.support.terminal import echo, say_table
from tactile.cli.options import JSON


@click.command(epilog=examples("tactile planes", "tactile planes --json"))
@JSON
def planes(as_json: bool) -> None:
    """List the planes that detectors read."""
    from tactile.events.detector_file import SHIPPED, shipped_detectors  # the machine is not for --help
    from tactile.events.planes import meanings  # the same

    found = dict(meanings())
    for detector in shipped_detectors(SHIPPED):
        for name in detector.program.outputs:
            found.setdefault(name, f"output of {detector.name}: {detector.program.summary}")
    if as_json:
        print_json(found)
        return
    say_table(found.items())


@click.command(
    epilog=examples("tactile codes 0101010101010101", "tactile codes 0xd8d8", "tactile codes", "tactile codes --json")
)
@click.argument("code", nargs=-1, metavar="[CODE]...")
@JSON
def codes(code: tuple[str, ...], as_json: bool) -> None:
    """Show the directions that sign codes stand for.

    CODE is that of two 2 x 2 fingers: 16 bits, 0xd8d8 or a number up to 65535; all codes without one.

    Two bits a taxel (x, then y; 1 is plus), row by row, the first finger highest, as in the events' "hand", which is
    hexadecimal: letters or a 0 in front say so, too.
    """
    from tactile.events.dictionary import entries, word  # NumPy is slow to import

    wanted = [(number, word(number)) for number in map(_number, code)] if code else list(entries())
    if as_json:
        print_json({f"{number:016b}": what for number, what in wanted})
        return
    echo("\n".join(f"{number:016b} {number:>5}  {what}" for number, what in wanted))


def _number(text: str) -> int:
    if len(text) != 16 or not set(text) <= {"0", "1"}:
        whole = text.isdecimal() and (text == "0" or text[0] != "0")
        digits = text.lower().removeprefix("0x")
        if whole and int(text) < 1 << 16:
            if len(text) == 4:  # the table of events has four columns
                echo(f"{text}: read as a decimal number; 0x{text} is the code that events print so", err=True)
            return int(text)
        if whole or not 1 <= len(digits) <= 4 or not set(digits) <= set("0123456789abcdef"):
            raise click.UsageError(
                f"code {text!r}; 16 bits, hexadecimal digits as 0xd8d8, or a number from 0 to 65535 wanted"
            )
        return int(digits, 16)
    return int(text, 2)
