"""Read the header comments of a ``.tem`` file: boundary, initial state, input, running time, cell model."""

import re
from dataclasses import dataclass, replace

from cnnsim.formats.candy.content import TemFile
from cnnsim.formats.numbers import is_number, number
from cnnsim.library.entry import Role
from cnnsim.network import PERIODIC, ZERO_FLUX, Boundary, fixed
from cnnsim.planning.step import Duration
from cnnsim.support import Diagnostics, InputError

_PART = re.compile(r"\s*([A-Za-z]\w*)\s*[:=]\s*([^,(]*(?:\([^)]*\))?[^,]*)(?:,|$)")
_CALLED = re.compile(r"([A-Za-z][A-Za-z -]*?)\s*(?:\(\s*(\S+?)\s*\))?", re.I)
_PICTURE = re.compile(r"P\d*(?:\(t\))?", re.I)
_TIME = re.compile(r"(\S+)\s*(?:tau|time constants?|t)?\.?", re.I)


@dataclass(frozen=True)
class Setting:
    """The setting of a template. ``discrete``: DT-CNN; ``given``: the keys that the header has."""

    input: Role = "picture"
    initial_state: Role = "picture"
    boundary: Boundary = ZERO_FLUX
    duration: Duration = "settled"
    discrete: bool = False
    given: frozenset[str] = frozenset()


def read_setting(tem: TemFile, report: Diagnostics) -> Setting:
    """Read %Setting, %Timing and %CNNModel; an unknown value gives a warning and the default."""
    header = tem.header("Setting")
    parts = {key.lower(): value.strip() for key, value in _PART.findall(header.text)}
    setting = Setting(given=frozenset(parts) & {"input", "inistate", "boundary"})
    rest = _PART.sub("", header.text).strip(" ,.-")
    if rest or parts.keys() - {"input", "inistate", "boundary"}:
        report.warning(header.line, f"%Setting: not all is understood: {header.text!r}")
    role = _role(parts.get("input", "P"), report, header.line, "Input")
    state = _role(parts.get("inistate", "P"), report, header.line, "IniState")
    first, second = parts.get("input", ""), parts.get("inistate", "")
    if role == state == "picture" and first and second and _which(first) != _which(second):
        state = "given"
    if state == "none":
        report.warning(header.line, "%Setting: no initial state; 'any' written, that is 0")
        state = "any"
    boundary = read_boundary(parts["boundary"], report, header.line) if "boundary" in parts else ZERO_FLUX
    setting = replace(setting, input=role, initial_state=state, boundary=boundary)
    return replace(setting, duration=_duration(tem, report), discrete=_discrete(tem))


def _which(picture: str) -> str:
    """Return P for P1: in ``Input:P, IniState:P1`` both are the first picture."""
    return picture.lower().removesuffix("(t)").removesuffix("1")


def _role(text: str, report: Diagnostics, line: int, key: str) -> Role:
    """Return our role: a picture, a number, ``Arbitrary(0)`` (any), or ``-`` (none)."""
    if text in ("", "-"):
        return "none"
    if _PICTURE.fullmatch(text):
        return "picture"
    called = _CALLED.fullmatch(text)
    value = text
    if called and called[1].strip().lower() in ("arbitrary", "any"):
        if key == "IniState" and float_or(called[2], 0.0) == 0:
            return "any"
        value = called[2] or "0"
    elif called and called[2] and called[1].strip().lower() in ("constant", "const", "fixed", "c"):
        value = called[2]
    if is_number(value) and abs(number(value)) <= 1:
        return number(value)
    report.warning(line, f"%Setting: {key} {text!r} is not understood; the picture is taken")
    return "picture"


def float_or(text: str | None, default: float) -> float:
    """Return the number that a text is, or the default."""
    return number(text) if text and is_number(text) else default


def read_boundary(text: str, report: Diagnostics, line: int | None) -> Boundary:
    """Read ``Fixed(v)``, ``Zero-flux`` or ``Periodic``; anything else is a warning, and zero-flux stands."""
    called = _CALLED.fullmatch(text.strip())
    kind = called[1].lower().replace(" ", "").replace("-", "") if called else ""
    if called and kind in ("fixed", "constant") and called[2] and is_number(called[2]):
        try:
            return fixed(number(called[2]))
        except InputError as error:
            report.warning(line, f"boundary {text!r}: {error}; zero-flux is taken")
            return ZERO_FLUX
    if kind in ("zeroflux", "periodic", "torus", "toroidal", "circular"):
        return ZERO_FLUX if kind == "zeroflux" else PERIODIC
    report.warning(line, f"boundary {text!r} is not understood; zero-flux is taken")
    return ZERO_FLUX


def _duration(tem: TemFile, report: Diagnostics) -> Duration:
    header = tem.header("Timing")
    if header.text.strip(" -?.") == "":
        return "settled"
    match = _TIME.fullmatch(header.text)
    value = float_or(match and match[1], 0.0)
    if value > 0:
        return value
    report.warning(header.line, f"%Timing: {header.text!r} is not understood; 'settled' is taken")
    return "settled"


def _discrete(tem: TemFile) -> bool:
    return "DT-CNN" in tem.header("CNNModel").text.upper().replace("DTCNN", "DT-CNN")
