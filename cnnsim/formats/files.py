"""Which reader is for which file, and from a file to the template files that it stands for."""

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

from cnnsim.formats.candy.imported import tem_drafts
from cnnsim.formats.candy.parse import read_tem
from cnnsim.formats.celnn_json import read_celnn
from cnnsim.formats.cnnsim_text import read_cnnsim
from cnnsim.formats.defects import defects
from cnnsim.formats.gene import read_gene
from cnnsim.formats.matcnn import matcnn_drafts, read_matcnn
from cnnsim.library.catalogue import folder as shipped_folder
from cnnsim.library.catalogue import load_file
from cnnsim.library.imported import Draft
from cnnsim.library.write import template_file
from cnnsim.support.errors import InputError
from cnnsim.support.findings import Report


def _tem(data: bytes, stem: str, report: Report) -> list[Draft]:
    tem = read_tem(data, report)
    return [] if report.failed else tem_drafts(tem, stem, report)


def _matcnn(data: bytes, stem: str, report: Report) -> list[Draft]:
    return matcnn_drafts(read_matcnn(data, report), report)


def _celnn(data: bytes, stem: str, report: Report) -> list[Draft]:
    return read_celnn(data, report)


READERS: dict[str, Callable[[bytes, str, Report], list[Draft]]] = {
    "tem": _tem,
    "matcnn": _matcnn,
    "cnnsim": read_cnnsim,
    "gene": read_gene,
    "json": _celnn,
}
_SUFFIXES = {".tem": "tem", ".m": "matcnn", ".cnnsim": "cnnsim", ".gene": "gene", ".json": "json"}
_SYSTEMS = {"tem": "CANDY", "matcnn": "MATCNN", "cnnsim": "CNNSim", "gene": "M.Teti", "json": "celnn"}
_OF_PARTS = {"matcnn", "json"}  # files of many templates: an error in one leaves the others good


@dataclass
class Imported:
    """What became of one file: its report, the files that were written, the drafts that were not."""

    report: Report
    written: list[Path] = field(default_factory=list)
    not_written: list[Draft] = field(default_factory=list)


def file_format(path: Path, given: str | None = None) -> str:
    """Return the format of a file by its suffix.

    Raises:
        InputError: the suffix is not known and no format is given.
    """
    found = given or _SUFFIXES.get(path.suffix.lower())
    if found is None:
        raise InputError(f"the suffix {path.suffix!r} is not known; say --format with one of {', '.join(READERS)}")
    return found


def import_file(path: Path, folder: Path, given: str | None = None, *, replace: bool = False) -> Imported:
    """Read a file and write a template file for every template in it; all complaints are in the report."""
    result = Imported(Report(str(path)))
    report = result.report
    try:
        kind = file_format(path, given)
        drafts = READERS[kind](path.read_bytes(), path.stem, Report(path.name, report.items))
    except (InputError, OSError) as error:
        report.error(None, error.strerror or str(error) if isinstance(error, OSError) else str(error))
        return result
    if report.failed and kind not in _OF_PARTS:
        return result
    for draft in drafts:
        draft = _with_defects(draft, path.stem, kind, report)
        if draft.missing:
            report.warning(None, f"{draft.name}: {draft.missing}")
            result.not_written.append(draft)
        elif target := _write(draft, folder, report, replace):
            result.written.append(target)
    return result


def _with_defects(draft: Draft, stem: str, kind: str, report: Report) -> Draft:
    source_name = stem if kind == "tem" else (draft.aliases or (draft.name,))[0]
    for text in defects(draft, source_name, _SYSTEMS[kind]):
        report.warning(None, f"{draft.name}: {text}")
        draft = draft.with_note(f"Warning: {text}{'' if text.endswith('.') else '.'}")
    return draft


def _write(draft: Draft, folder: Path, report: Report, replace: bool) -> Path | None:
    target = folder / f"{draft.name}.toml"
    if target.exists() and not replace:
        report.error(None, f"{target} is there already; --replace would write over it")
        return None
    if (shipped_folder() / target.name).is_file():
        report.warning(None, f"{draft.name}: where {folder} is searched this hides the shipped template of that name")
    try:
        folder.mkdir(parents=True, exist_ok=True)
        target.write_text(template_file(draft), encoding="utf-8")
        load_file(target)  # what is written can be used
    except OSError as error:
        report.error(None, f"{target}: {error.strerror}")
        return None
    except InputError as error:
        target.unlink()
        report.error(None, str(error))
        return None
    return target
