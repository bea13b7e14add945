"""The command `explain`: how a template, or each template step of a program, would be computed, and why."""

from dataclasses import asdict
from typing import TYPE_CHECKING

import click

from cnnsim.cli.large import block_option, check_engine_options, engine_option, workers_option
from cnnsim.cli.run import json_option, without_option
from cnnsim.library.explain import COUNTED, explain_template
from cnnsim.program.explain import explain_program
from cnnsim.program.file import find_program
from cnnsim.program.program import Program
from cnnsim.support import InputError
from cnnsim.support.command_line import examples, print_json
from cnnsim.support.terminal import say, say_table

if TYPE_CHECKING:
    from cnnsim.program.explain_large import LargeProgram


@click.command(
    epilog=examples(
        "cnnsim explain edge",
        "cnnsim explain hole-filler --size 512x512 --without sleep",
        "cnnsim explain diffusion --accuracy 1e-6",
        "cnnsim explain median --size 4096x4096 --backend opencl",
        "cnnsim explain slip-front --size 16x16",
        "cnnsim explain skeleton --size 32768x32768 --engine processes",
    )
)
@click.argument("name")
@click.option("--size", default="64x64", show_default=True, help="Grid as ROWSxCOLS.")
@click.option("--accuracy", help="As in `cnnsim run`: what it would decide.")
@click.option(
    "--backend", type=click.Choice(COUNTED), default="cpu", show_default=True, help="Whose memory is counted."
)
@without_option
@engine_option
@workers_option
@block_option
@json_option
def explain(
    name: str, size: str, accuracy: str | None, backend: str, without: tuple[str, ...], engine: str | None,
    workers: int | None, block: int | None, as_json: bool,
) -> None:  # fmt: skip
    """Print how a template or a program would be computed.

    That is what the plan decides for a template, or for each template step of a program, and why.

    NAME is one of the library, or a file; where a template and a program share it, programs/NAME is the program. With
    --engine also the blocks of a program, its planes on the disk and their bytes.
    """
    shape = _shape(size)
    check_engine_options(engine, None, workers, block)
    program = find_program(name)
    if program is not None:
        if without or accuracy:
            given = f"--without {without[0]}" if without else f"--accuracy {accuracy}"
            raise InputError(f"{given}: {name} is a program; {given.split()[0]} goes with templates")
        large = None
        if engine is not None:
            from cnnsim.program.explain_large import explain_large  # it and the next bring Zarr
            from cnnsim.supersteps.engine import Engine

            at = Engine(engine, workers=workers, side=block)
            large = explain_large(program, shape, at, backend=backend)
        _explain_steps(program, shape, large, as_json)
        return
    if engine is not None:
        raise InputError(f"--engine {engine}: {name} is a template; a program wanted")
    found = explain_template(name, shape, backend, without=without, accuracy=accuracy)
    if as_json:
        plan, known = found.plan, found.guaranteed
        facts = {"template": name, "method": plan.method, "step": plan.step, "decisions": plan.decisions}
        facts |= {"bytes_a_cell": found.cell_bytes, "backend": found.backend, "cells": found.cells}
        print_json(facts | {"guaranteed_time": known.time, "why": known.why, "assuming": known.assuming})
    else:
        say_table(found.lines)


def _explain_steps(program: Program, shape: tuple[int, int], large: "LargeProgram | None", as_json: bool) -> None:
    steps = explain_program(program, shape)
    if as_json:
        keys = ("number", "words", "method", "decisions")
        facts = {"program": program.name, "steps": [{key: getattr(step, key) for key in keys} for step in steps]}
        print_json(facts | ({} if large is None else {"engine": asdict(large)}))
        return
    for step in steps:
        say(f"step {step.number}: {step.words}")
        say_table([(f"  {what}", why) for what, why in step.decisions])
    if not steps:
        say(f"{program.name} runs no template: all of its steps are cellwise or logic")
    if large is not None:
        say("on the engine:")
        say_table([(f"  {what}", found) for what, found in large.lines])


def _shape(size: str) -> tuple[int, int]:
    try:
        rows, cols = (int(part) for part in size.lower().split("x"))
        if min(rows, cols) < 1:
            raise ValueError
    except ValueError as error:
        raise InputError(f"size {size!r}; ROWSxCOLS wanted, such as 64x64") from error
    return rows, cols
