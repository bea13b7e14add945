"""Sweep of thresholds: labelled recordings scored with each choice."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from cnnsim.support import InputError
from cnnsim.sweep.kind import Case, Kind, Row
from tactile.core.source import Source, provenance
from tactile.score.labels import read_labels
from tactile.score.match import WINDOW
from tactile.score.measure import MARK, labelled_sources, score
from tactile.settings import PipelineOptions, Settings
from tactile.thresholds.levels import SIGMAS

SIGMA_KEYS = {"dead_band_sigmas": "dead_band", "hysteresis_sigmas": "hysteresis", "contact_sigmas": "contact"}
KEYS = {
    "recordings": "the folder of the recordings",
    "labels": "the CSV file of their labels, as for tactile score",
    "window_ms": "the largest distance of an event's start from its label [ms]; default 50",
    "dead_band": "least threshold of shear, as --dead-band",
    "hysteresis": "as --hysteresis",
    "contact_level": "least threshold of contact, as --contact-level",
    "dead_band_sigmas": "dead band as multiple of a taxel's noise, the first number of --sigmas",
    "hysteresis_sigmas": "hysteresis, the second",
    "contact_sigmas": "contact level, the third",
    "program": "a detector or program file",
}


def options_of(case: Case) -> PipelineOptions:
    """Return the pipeline's options that a case chooses."""
    given = {key: case[key] for key in ("dead_band", "hysteresis", "contact_level") if key in case}
    chosen = {name: case[key] for key, name in SIGMA_KEYS.items() if key in case}
    sigmas = replace(SIGMAS, **chosen)
    program = (case["program"],) if "program" in case else ()
    return PipelineOptions(
        **given, sigmas=(sigmas.dead_band, sigmas.hysteresis, sigmas.contact) if chosen else None, program=program
    )


def check(case: Case) -> None:
    """Check that a case has its files, and thresholds that go together."""
    if not Path(case["recordings"]).is_dir():
        raise InputError(f"no folder {case['recordings']} of recordings")
    read_labels(Path(case["labels"]))
    options_of(case).thresholds()


def run(cases: Sequence[Case]) -> list[Row]:
    """Score the recordings with each choice."""
    return [run_one(case) for case in cases]


def run_one(case: Case) -> Row:
    """Score the recordings with one choice: for each kind precision, recall and errors of the onset, and the rest."""
    options = options_of(case)

    def settings(source: Source) -> Settings:
        return replace(options, tare="auto" if provenance(source).untared else "off").settings(source)

    window = case["window_ms"] * 1e-3 if "window_ms" in case else WINDOW
    missing, sources = labelled_sources(Path(case["recordings"]), read_labels(Path(case["labels"])))
    found = score(sources, settings, window, missing).plain()
    row: Row = {}
    for kind, figures in found.pop("kinds").items():
        if not kind.startswith(MARK):  # baselines have no thresholds
            errors = figures.pop("onset_error_s") or (None, None, None)
            row |= {f"{kind}_{name}": value for name, value in figures.items()}
            row |= {f"{kind}_onset_ms_{part}": None if one is None else 1e3 * one for part, one in
                    zip((5, 50, 95), errors, strict=True)}  # fmt: skip
    return row | _flat(found)


def _flat(plain: dict[str, Any]) -> Row:
    """Return nested tables as one table, with joined names."""
    row: Row = {}
    for name, value in plain.items():
        if isinstance(value, dict):
            row |= _flat({f"{name}_{inner}": one for inner, one in value.items()})
        elif value is None or isinstance(value, int | float | str):
            row[name] = value
    return row


KIND = Kind(keys=KEYS, run=run, needed=("recordings", "labels"), check=check, paths=("recordings", "labels", "program"))
