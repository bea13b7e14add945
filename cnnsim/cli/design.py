"""The command `design`: templates for a rule over the 3 x 3 window, or for pairs of pictures."""

import re
from pathlib import Path
from typing import Any

import click

from cnnsim.cli.run import json_option
from cnnsim.network import parse_boundary
from cnnsim.network.boundary import BOUNDARY_FORMS
from cnnsim.support import InputError
from cnnsim.support.command_line import examples, print_json, progress
from cnnsim.support.terminal import say

_FILE = click.Path(path_type=Path)


@click.command(
    epilog=examples(
        'cnnsim design --rule "c and ring8 < 8" --name my-edge -o designs/',
        'cnnsim design --rule "all9 % 2 == 1" --name parity -o designs/',
        'cnnsim design --rule "c xor x" --name differs -o designs/ --json',
        "cnnsim design --table rule.toml --name my-rule -o designs/",
        "cnnsim design --pair before.png=after.png --name learned -o designs/",
        "cnnsim design --pair before.png=after.png --coupled --state 1 --name filled -o designs/",
    )
)
@click.option("--rule", "text", help="An expression, such as 'c and (n + e + s + w) < 4'; names as above.")
@click.option("--table", type=_FILE, help="A truth table: TOML with black, white (lists of windows) and default.")
@click.option("--pair", "pairs", multiple=True, metavar="INPUT=OUTPUT", help="Two pictures: what should become what.")
@click.option("--name", required=True, help="Name of the template, and of its files.")
@click.option("-o", "--output", type=_FILE, required=True, help="Folder for the files.")
@click.option("--norm", type=click.Choice(["sum", "largest"]), default="sum", show_default=True,
              help="Make the margin large compared with the sum of |weights|, or with the largest.")  # fmt: skip
@click.option("--most", type=click.IntRange(1), default=32, show_default=True,
              help="The most templates of a rule; each takes the search about a second.")  # fmt: skip
@click.option("--boundary", default="fixed:-1", show_default=True, help=f"{BOUNDARY_FORMS}.")
@click.option("--coupled", is_flag=True, help="Fit a template with neighbours in A to the pairs, by evolution.")
@click.option("--state", default="picture", show_default=True, help="For --coupled: x(0), the picture or a number.")
@click.option("--symmetry", type=click.Choice(["all", "mirror", "none"]), default="all", show_default=True,
              help="For --coupled: entries that are equal in all directions, left and right, or none.")  # fmt: skip
@click.option("--generations", type=click.IntRange(1), default=60, show_default=True, help="For --coupled.")
@click.option("--seed", type=click.IntRange(0), default=0, show_default=True, help="For --coupled.")
@click.option("--replace", is_flag=True, help="Write over files that are there already.")
@json_option
def design(
    text: str | None, table: Path | None, pairs: tuple[str, ...], name: str, output: Path, boundary: str,
    coupled: bool, replace: bool, as_json: bool, **options: Any,
) -> None:  # fmt: skip
    """Find templates for a rule, or for pairs of pictures.

    A rule is over the 3 x 3 window; the templates are written with worked examples.

    In a rule c n ne e se s sw w nw are 1 for black and 0 for white, x is the cell's own initial state; ring4, ring8 and
    all9 are sums; and or xor not, comparisons, + - * % and brackets work as usual. One template of the largest margin
    is found if there is one; otherwise a certificate says why not, and a program of a few templates is written.
    """
    if (text is not None) + (table is not None) + bool(pairs) != 1:
        raise InputError("a rule is wanted: exactly one of --rule, --table and --pair (as often as there are pairs)")
    if not re.fullmatch(r"[a-z0-9]+(-[a-z0-9]+)*", name):
        raise InputError(f"name {name!r}; small letters, digits and hyphens wanted, such as my-edge")
    from cnnsim.prototyping.design import report

    around = parse_boundary(boundary)
    if coupled:
        if not pairs:
            raise InputError("--coupled fits a template to pictures: give --pair INPUT=OUTPUT")
        with progress(name) as track:
            facts, lines = report.fitted(pairs, name, output, around, options, track, replace=replace)
    else:
        facts, lines = report.designed(text, table, pairs, name, output, around, options, replace=replace)
    if as_json:
        print_json(facts)
    else:
        for line in lines:
            say(line, 10)
