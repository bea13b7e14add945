"""Training files: pairs of pictures, stages and options, read from TOML."""

from collections.abc import Mapping
from dataclasses import fields
from pathlib import Path
from typing import Any

from cnnsim import library
from cnnsim.learning.stage import Stage
from cnnsim.learning.training_task import TrainingTask
from cnnsim.support import InputError
from cnnsim.support.error_list import ErrorList
from cnnsim.support.errors import naming
from cnnsim.support.files import check_name
from cnnsim.support.pictures.read import read_pictures
from cnnsim.support.toml_file import check_keys, located, read_toml, take, take_tables

_OPTIONS = [option.name for option in fields(TrainingTask) if option.name not in ("pairs", "stages")]
_STAGE = [option.name for option in fields(Stage)]


def read_training(path: Path) -> TrainingTask:
    """Read a training file: options of `TrainingTask`, [[pair]] and [[stage]] tables.

    A pair has the files ``input``, ``output`` and perhaps ``state`` (the second picture), each of one picture or of as
    many as the others; with a ``frame_time`` the pictures of a file are one sequence. Paths are relative to the file. A
    stage has the keys of `Stage`; ``terms`` names a template whose terms are trained.

    Raises:
        InputError: unknown keys, pictures that cannot be read or differ in number; as `TrainingTask`.
    """
    table = read_toml(path, "training")
    errors = ErrorList(str(path))
    errors.check(table, (*_OPTIONS, "pair", "stage"), required=("name", "pair"))
    pairs: list[tuple[Any, ...]] = []
    stages: list[Stage] = []
    for number, pair in enumerate(_tables(table, "pair", errors), start=1):
        with errors.collecting(pair, where=f"[[pair]] {number}"):
            pairs += _pairs(path.parent, pair, table)
    for number, stage in enumerate(_tables(table, "stage", errors), start=1):
        with errors.collecting(stage, where=f"[[stage]] {number}"):
            stages.append(_stage(stage))
    with errors.collecting():
        check_name(take(table, "name", str, "training"), "training")
    errors.raise_all()
    with naming(path):
        return TrainingTask(pairs, stages or [Stage()], **{key: table[key] for key in _OPTIONS if key in table})


def _tables(table: Mapping[str, Any], key: str, errors: ErrorList) -> list[dict[str, Any]]:
    with errors.collecting():
        return take_tables(table, key, "training")
    return []


def _pairs(folder: Path, table: Mapping[str, Any], options: Mapping[str, Any]) -> list[tuple[Any, ...]]:
    check_keys(table, ("input", "output", "state"), required=("input", "output"))
    keys = [key for key in ("input", "output", "state") if key in table]
    found = [read_pictures(folder / take(table, key, str, "pair")) for key in keys]
    if "frame_time" in options:
        second = [pictures[0] for pictures in found[2:]]
        return [(found[0], found[1] if options.get("times") else found[1][-1], *second)]
    if len({len(pictures) for pictures in found}) > 1:
        numbers = ", ".join(f"{key} has {len(pictures)} pictures" for key, pictures in zip(keys, found, strict=True))
        raise InputError(f"{numbers}; one number wanted")
    return list(zip(*found, strict=True))


def _stage(table: Mapping[str, Any]) -> Stage:
    check_keys(table, _STAGE)
    given = dict(table)
    if "terms" in table:
        with located(table, "terms"):
            given["terms"] = library.load(take(table, "terms", str, "stage")).template.terms
    return Stage(**given)
