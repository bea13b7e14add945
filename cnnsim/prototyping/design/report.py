"""Design a template, write it, check it and report: facts as JSON and lines of text."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace as replace_fields
from pathlib import Path
from typing import Any

from cnnsim import library
from cnnsim.library.entry import Example, LibraryEntry, Role
from cnnsim.library.write import template_text
from cnnsim.network import Boundary
from cnnsim.prototyping.design.decompose import design_rule
from cnnsim.prototyping.design.design import Design
from cnnsim.prototyping.design.expression import parse_rule
from cnnsim.prototyping.design.files import part_names, write_design
from cnnsim.prototyping.design.fit import fit
from cnnsim.prototyping.design.linear import Certificate, Norm
from cnnsim.prototyping.design.rule import WindowRule, window_text
from cnnsim.prototyping.design.rule_files import read_pairs, read_table, rule_of_pairs
from cnnsim.prototyping.design.verify import wrong_windows
from cnnsim.support import InputError
from cnnsim.support.command_files import check_free
from cnnsim.support.files import write_text

Facts = tuple[dict[str, Any], list[str]]


def designed(
    text: str | None, table: Path | None, pairs: Sequence[str], name: str, folder: Path, boundary: Boundary,
    options: dict[str, Any], *, replace: bool = False,
) -> Facts:  # fmt: skip
    """Design templates for a rule, write them, run them on every window, and report.

    Arguments: ``options`` are the norm of the weights and the most templates, as `design_rule` takes them.

    Raises:
        InputError: the rule is wrong or takes too many templates, files are there and not to be replaced, or the folder
            cannot be written.
    """
    pictures = read_pairs(pairs)
    if text is not None:
        rule = parse_rule(text)
    elif table is not None:
        rule = read_table(table)
    else:
        rule = rule_of_pairs(pictures, boundary)
    norm: Norm = options["norm"]
    found = design_rule(rule, norm, options["most"])
    paths = write_design(found, name, boundary, folder, [picture for picture, _ in pictures], replace=replace)
    program = None if found.one_template else paths[-1]
    wrong = wrong_windows(found, program)
    if wrong:
        raise ArithmeticError(f"{len(wrong)} windows are wrong, the first {window_text(rule.rows[wrong[0]])}")
    return _facts(found, name, paths, norm), _lines(found, name, paths, norm)


def _facts(found: Design, name: str, paths: list[Path], norm: Norm) -> dict[str, Any]:
    templates = []
    for part, part_name in zip(found.parts, part_names(found, name), strict=True):
        t = part.template(part_name)
        relative = part.separator.relative_margin(norm)
        templates.append({"name": part_name, "A": t.A.tolist(), "B": t.B.tolist(), "z": t.z, "margin": 1.0,
                          "relative_margin": relative, "state": part.state, "negated": part.negated})  # fmt: skip
    certificate = None
    if found.certificate is not None:
        certificate = {
            colour: [{"share": str(share), "window": window_text(found.rule.rows[i])} for share, i in side]
            for colour, side in (("black", found.certificate.black), ("white", found.certificate.white))
        }
    return {
        "rule": found.rule.text, "single": found.one_template, "join": found.join, "norm": norm, "templates": templates,
        "certificate": certificate, "windows": int((found.rule.table != 0).sum()), "wrong": 0,
        "files": [str(path) for path in paths],
    }  # fmt: skip


def _lines(found: Design, name: str, paths: list[Path], norm: Norm) -> list[str]:
    known = int((found.rule.table != 0).sum())
    lines = [f"rule      {found.rule.text}: {_windows(found.rule, known)}"]
    if found.certificate is not None:
        lines += ["single    no template can do it alone: a mean of black windows is a mean of white ones"]
        lines += certificate_lines(found.certificate, found.rule)
    many = len(found.parts)
    joined = (
        "" if many == 1 else f", joined by {found.join}" if found.join != "last" else ", each starting from the last"
    )
    lines.append(f"templates {many}{joined}")
    for part, part_name in zip(found.parts, part_names(found, name), strict=True):
        t = part.template(part_name)
        b = " / ".join(" ".join(f"{value:g}" for value in row) for row in t.B)
        lines.append(f"  {part_name}: a = {t.self_feedback:g}, B = {b}, z = {t.z:g}")
    measure = "sum" if norm == "sum" else "largest"
    lines.append(f"margin    1, that is {found.relative_margin(norm):.4g} of the {measure} of |B|, |z| and a - 1")
    lines.append(f"checked   all {known} windows, by running {'the template' if found.one_template else 'the program'}")
    return [*lines, *(f"-> {path}" for path in paths)]


def certificate_lines(certificate: Certificate, rule: WindowRule) -> list[str]:
    """Return the certificate as text: shares of windows, black ones and white ones."""
    return [
        f"  {colour}  " + " + ".join(f"{share} {window_text(rule.rows[i])}" for share, i in side)
        for colour, side in (("black", certificate.black), ("white", certificate.white))
    ]


def _windows(rule: WindowRule, known: int) -> str:
    black = int((rule.table > 0).sum())
    return f"{black} of {known} windows become black" + (
        f", {rule.table.size - known} are open" if known < rule.table.size else ""
    )


def fitted(
    texts: Sequence[str], name: str, folder: Path, boundary: Boundary, options: dict[str, Any],
    track: Callable[[Iterable[Any]], Iterable[Any]], *, replace: bool = False,
) -> Facts:  # fmt: skip
    """Fit a coupled template to pairs of pictures, write it with the pairs as its examples, and report.

    A template that leaves cells wrong is written as NAME-attempt, without examples.

    Raises:
        InputError: pictures that cannot be read, a state that is neither "picture" nor a number from -1 to 1, a file
            that is there and not to be replaced, or no template that gives the pairs.
    """
    path, attempt = folder / f"{name}.toml", folder / f"{name}-attempt.toml"
    check_free(path, attempt, replace=replace)  # before the minutes that the search takes
    pairs = read_pairs(texts)
    state = _state(options["state"])
    bar = iter(track(range(options["generations"] + 1)))
    next(bar, None)
    found = fit(
        pairs, boundary, name=name, symmetry=options["symmetry"], initial_state=state, seed=options["seed"],
        generations=options["generations"], report=lambda *_: next(bar, None),
    )  # fmt: skip
    note = "What it does to other pictures is not known."
    entry = LibraryEntry(
        name, f"Fitted to {len(pairs)} pair{'s' * (len(pairs) != 1)} of pictures, which are its examples.",
        f"Fitted by differential evolution, seed {options['seed']}", found.template, initial_state=state,
        boundary=boundary, tags=("fitted", "uncoupled" if found.template.uncoupled else "coupled", "binary"), note=note,
        examples=tuple(Example(u, None, y) for u, y in pairs),
    )  # fmt: skip
    if found.wrong:
        wrong = f"Fitted to pictures; {found.wrong} of {found.cells} cells are wrong."
        kept = replace_fields(entry, name=attempt.stem, summary=wrong, examples=())
        write_text(attempt, template_text(kept), replace=replace, follow=False)
        raise InputError(
            f"no template found that gives the pairs: the best leaves {found.wrong} of {found.cells} cells wrong after "
            f"{found.runs} runs and is kept as {attempt}; try more --generations, another --seed, --symmetry none, or "
            "another --state"
        )
    t = found.template
    write_text(path, template_text(entry), replace=replace, follow=False)
    for example in (entry := library.load_file(path)).examples:
        assert example.holds(library.run_example(entry, example, limit=500.0).y)
    facts = {"name": name, "A": t.A.tolist(), "B": t.B.tolist(), "z": t.z, "initial_state": state, "wrong": 0,
             "cells": found.cells, "runs": found.runs, "files": [str(path)]}  # fmt: skip
    a, b = ([" ".join(f"{v:g}" for v in row) for row in matrix] for matrix in (t.A, t.B))
    lines = [
        f"template  A = {' / '.join(a)}, B = {' / '.join(b)}, z = {t.z:g}, x(0) = {state}",
        f"checked   all {found.cells} cells of {len(pairs)} pairs are right, after {found.runs} runs",
        f"-> {path}",
    ]
    return facts, lines


def _state(text: str) -> Role:
    if text == "picture":
        return "picture"
    try:
        value = float(text)
    except ValueError:
        value = float("nan")
    if not -1 <= value <= 1:
        raise InputError(f"--state {text!r}; 'picture' or a number from -1 to 1 wanted")
    return value
