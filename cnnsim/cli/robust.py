"""The command `robust`: how precise a chip must be for a template."""

from pathlib import Path

import click

from cnnsim import library
from cnnsim.cli.run import json_option
from cnnsim.support.command_line import examples, print_json, progress
from cnnsim.support.echo import echo, say, say_table


@click.command(
    epilog=examples(
        "cnnsim robust edge -o curve.png",
        "cnnsim robust hole-filler --draws 100 -o curve.png",
        "cnnsim robust corner --json",
    )
)
@click.argument("name")
@click.option("-o", "--output", type=click.Path(path_type=Path), help="Where the curves go (PNG, SVG, PDF).")
@click.option("--draws", type=click.IntRange(1, 10_000), default=40, show_default=True, help="Random chips a level.")
@click.option("--seed", type=click.IntRange(0), default=0, show_default=True)
@json_option
def robust(name: str, output: Path | None, draws: int, seed: int, as_json: bool) -> None:
    """Tell how precise a chip must be for template NAME.

    The margin, and the share of wrong cells under random errors of the entries (0.1 % to 20 %), entries of 3 to 12
    bits, and noise on the picture.
    """
    from cnnsim.prototyping.robust.robust import measure

    with progress(name) as track:
        found = measure(library.load(name), draws=draws, seed=seed, track=track)
    if output is not None:
        from cnnsim.prototyping.robust.plot import draw_robustness

        draw_robustness(found, output)
    if as_json:
        curves = {kind: vars(getattr(found, kind)) for kind in ("entries", "bits", "noise")}
        print_json({"template": name, "margin": vars(found.margin), "judged_on": found.judged_on, **curves,
                    "bits_needed": found.bits_needed(), "draws": draws, "seed": seed})  # fmt: skip
        return
    say(f"{name}, judged on {found.judged_on}")
    say_table(found.rows())
    if output is not None:
        echo(f"-> {output}")
