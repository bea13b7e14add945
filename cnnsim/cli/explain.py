"""The command `explain`: how a template, or each template step of a program, would be computed, and why."""

import click

from cnnsim.cli.run import json_option, without_option
from cnnsim.library.explain import COUNTED, explain_template
from cnnsim.program.explain import explain_program
from cnnsim.program.file import find_program
from cnnsim.program.program import Program
from cnnsim.support import InputError
from cnnsim.support.command_line import examples, print_json
from cnnsim.support.terminal import say, say_table


@click.command(
    epilog=examples(
        "cnnsim explain edge",
        "cnnsim explain hole-filler --size 512x512 --without sleep",
        "cnnsim explain diffusion --accuracy 1e-6",
        "cnnsim explain median --size 4096x4096 --backend opencl",
        "cnnsim explain slip-front --size 16x16",
    )
)
@click.argument("name")
@click.option("--size", default="64x64", show_default=True, help="Grid as ROWSxCOLS.")
@click.option("--accuracy", help="As in `cnnsim run`: what it would decide.")
@click.option(
    "--backend", type=click.Choice(COUNTED), default="cpu", show_default=True, help="Whose memory is counted."
)
@without_option
@json_option
def explain(name: str, size: str, accuracy: str | None, backend: str, without: tuple[str, ...], as_json: bool) -> None:
    """Print how a template or a program would be computed.

    That is what the plan decides for a template, or for each template step of a program, and why.

    NAME is one of the library, or a file; where a template and a program share it, programs/NAME is the program.
    """
    shape = _shape(size)
    program = find_program(name)
    if program is not None:
        if without or accuracy:
            given = f"--without {without[0]}" if without else f"--accuracy {accuracy}"
            raise InputError(f"{given}: {name} is a program; {given.split()[0]} goes with templates")
        _explain_steps(program, shape, as_json)
        return
    found = explain_template(name, shape, backend, without=without, accuracy=accuracy)
    if as_json:
        plan, known = found.plan, found.guaranteed
        facts = {"template": name, "method": plan.method, "step": plan.step, "decisions": plan.decisions}
        facts |= {"bytes_a_cell": found.cell_bytes, "backend": found.backend, "cells": found.cells}
        print_json(facts | {"guaranteed_time": known.time, "why": known.why, "assuming": known.assuming})
    else:
        say_table(found.lines)


def _explain_steps(program: Program, shape: tuple[int, int], as_json: bool) -> None:
    steps = explain_program(program, shape)
    if as_json:
        keys = ("number", "words", "method", "decisions")
        facts = {"program": program.name, "steps": [{key: getattr(step, key) for key in keys} for step in steps]}
        print_json(facts)
        return
    for step in steps:
        say(f"step {step.number}: {step.words}")
        say_table([(f"  {what}", why) for what, why in step.decisions])
    if not steps:
        say(f"{program.name} runs no template: all of its steps are cellwise or logic")


def _shape(size: str) -> tuple[int, int]:
    try:
        rows, cols = (int(part) for part in size.lower().split("x"))
        if min(rows, cols) < 1:
            raise ValueError
    except ValueError as error:
        raise InputError(f"size {size!r}; ROWSxCOLS wanted, such as 64x64") from error
    return rows, cols
