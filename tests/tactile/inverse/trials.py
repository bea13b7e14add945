"""Random trials of located loads against the truth: ``python -m tests.tactile.inverse.trials [--count N] [--seed K]``.

Pads of 2 x 2 to 32 x 32 taxels half a depth to four depths apart and lines of them, strain and stress, noise of 1e-6
to 3e-2 of the largest signal, one to three loads at least two depths apart, also outside the pad, and taxels that are
stuck, dead, saturated (which is known) or clipped (which is not). Gross: a load that is told to be inside lies 0.3
depths from any true one, or their number is wrong. Precision: places of single loads that are told to be inside over
the Cramer-Rao bound of the taxels that read rightly; where nobody knows that some are clipped there is none.
"""

import argparse
from collections import Counter, defaultdict
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cnnsim.support import Flags, Floats
from tactile.core.frame import TaxelArray
from tactile.inverse.load import Load
from tactile.inverse.validity import Validity
from tests.kits.touch.pads import DEPTH, SCALE, as_row, felt, found
from tests.oracles.elastic.localise import bound

SHAPES = ((2, 2), (2, 3), (3, 3), (4, 4), (5, 5), (8, 8), (16, 16), (32, 32), (1, 8), (6, 1))
GROSS = 0.3
"""[depths]"""


@dataclass(frozen=True)
class Trial:
    """One trial: what was there, what was read, what was located."""

    shape: tuple[int, int]
    stress: bool
    level: float
    known: bool
    fault: str
    outside: bool
    pitch: float
    loads: NDArray[np.float64]
    false: Flags
    load: Load
    ratio: Floats

    @property
    def gross(self) -> bool:
        """Whether the answer is told to be inside and is not."""
        if self.load.validity is not Validity.INSIDE:
            return False
        answers = (self.load, *self.load.others)
        off = [min(np.hypot(one.x - x, one.y - y) for x, y in self.loads[:, :2]) / DEPTH for one in answers]
        return bool(max(off) > GROSS or len(answers) != len(self.loads))


def trial(random: np.random.Generator) -> Trial:
    """Draw and locate one."""
    rows, cols = SHAPES[random.integers(len(SHAPES))]
    pitch = DEPTH * float(random.choice([0.5, 1, 1, 2, 4]))
    at, stress = TaxelArray("pad", rows, cols, pitch, DEPTH).positions(), bool(random.integers(2))
    half, line = np.array([cols, rows]) * pitch / 2, min(rows, cols) == 1
    outside = random.random() < 0.15
    roomy = 2 * half.max() > 5 * DEPTH and rows * cols >= 25
    count = 1 if outside or not roomy else int(random.choice([1, 1, 1, 2, 3]))
    loads = _loads(random, count, half, outside)
    if line:
        loads[:, 2 if cols == 1 else 3] = 0.0
    signals = felt(at, loads, stress)
    level, peak = 10 ** random.uniform(-6, np.log10(3e-2)), float(np.abs(signals).max())
    read = signals + random.normal(size=signals.shape) * level * peak
    fault = str(random.choice(["none", "none", "stuck", "saturated", "clipped", "dead"])) if rows * cols > 4 else "none"
    false, saturated = _broken(random, fault, read, peak)
    known = bool(random.integers(2))
    load = found(at, read, stress, level * peak if known else None, saturated)
    ratio = np.full(2, np.nan)
    if count == 1:
        told = (0, 1, *((2,) if rows == 1 else (3,) if cols == 1 else (2, 3)), 4)
        least = np.full(2, np.inf)
        with suppress(np.linalg.LinAlgError):  # too few are left
            least = bound(lambda p: felt(at, p, stress)[~false], loads[0], level * peak, SCALE, told)[:2]
        if least.max() < 0.05 * DEPTH:  # else the problem is not linear within its own errors
            ratio = (np.array(as_row(load)) - loads[0])[:2] / least
    return Trial((rows, cols), stress, level, known, fault, outside, pitch / DEPTH, loads, false, load, ratio)


def _loads(random: np.random.Generator, count: int, half: Floats, outside: bool) -> NDArray[np.float64]:
    while True:
        places = random.uniform(-1, 1, (count, 2)) * half
        if outside:
            axis = int(random.integers(2))
            places[0, axis] = random.choice([-1, 1]) * (half[axis] + random.uniform(0, 2) * DEPTH)
        gaps = [np.hypot(*(a - b)) for k, a in enumerate(places) for b in places[:k]]
        if min(gaps, default=np.inf) >= 2 * DEPTH:
            break
    forces = random.uniform(0.15, 0.4, count)
    shear = random.uniform(0, 1, count) * forces
    turn = random.uniform(0, 2 * np.pi, count)
    return np.column_stack([places, shear * np.cos(turn), shear * np.sin(turn), forces])


def _broken(random: np.random.Generator, fault: str, read: Floats, peak: float) -> tuple[Flags, Flags | None]:
    """Change readings as the fault has it, and return which are false, and which are known to be saturated."""
    rows, cols = read.shape[:2]
    false: Flags = np.zeros((rows, cols), bool)
    saturated: Flags | None = None
    row, col = random.integers(0, rows), random.integers(0, cols)
    if fault == "stuck":
        read[row, col] = random.normal(size=3) * peak * random.choice([0.3, 1, 3])
        false[row, col] = True
    elif fault == "dead":
        read[row, col] = 0.0
        false[row, col] = True
    elif fault in ("saturated", "clipped"):
        end = random.uniform(0.5, 0.9) * peak
        false[:] = (np.abs(read) > end).any(axis=-1)
        saturated = false if fault == "saturated" else None
        read[:] = np.clip(read, -end, end)
    return false, saturated


def report(trials: list[Trial]) -> str:
    """Return what the trials say, a line for each way in which they were drawn."""
    lines = []
    ways: dict[str, Callable[[Trial], object]] = {
        "all": lambda _: "all", "shape": lambda one: "{} x {}".format(*one.shape), "stress": lambda one: one.stress,
        "fault": lambda one: one.fault, "known noise": lambda one: one.known, "loads": lambda one: len(one.loads),
        "outside": lambda one: one.outside,
        "pitch": lambda one: one.pitch, "noise": lambda one: f"1e{int(np.floor(np.log10(one.level)))}",
    }  # fmt: skip
    for name, way in ways.items():
        groups = defaultdict(list)
        for one in trials:
            groups[way(one)].append(one)
        for value, members in sorted(groups.items(), key=str):
            gross = sum(one.gross for one in members)
            sure = [one for one in members if one.load.validity is Validity.INSIDE and not one.gross]
            sure = [one for one in sure if one.fault != "clipped"]
            ratios = np.array([one.ratio for one in sure])
            ratios = ratios[np.isfinite(ratios)]
            rms = float(np.sqrt(np.mean(ratios**2))) if ratios.size else np.nan
            q = float(np.quantile(np.abs(ratios), 0.68)) if ratios.size else np.nan
            kept = sum(one.load.validity is Validity.INSIDE and not one.gross for one in members)
            kinds = Counter(one.load.validity.name.lower() for one in members)
            lines.append(
                f"{name:12} {value!s:10} {len(members):5}  gross {gross:3} ({gross / len(members):.1%})"
                f"  good {kept / len(members):.1%}"
                f"  error/bound {rms:7.2f} rms {q:5.2f} of 68 %  {dict(kinds)}"
            )
    return "\n".join(lines)


def main() -> None:
    """Draw, locate, report."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--show", action="store_true", help="print every trial that went wrong")
    given = parser.parse_args()
    trials = []
    for n in range(given.count):
        one = trial(np.random.default_rng((given.seed, n)))
        trials.append(one)
        far = (
            one.fault != "clipped"
            and np.isfinite(one.ratio).all()
            and one.load.validity is Validity.INSIDE
            and np.abs(one.ratio).max() > 5
        )
        if given.show and (one.gross or far):
            print(n, one.shape, one.pitch, "stress" * one.stress, f"{one.level:.1e}", one.known, one.fault,
                  "gross" * one.gross,
                  np.round(one.loads[:, :2] / DEPTH, 2).tolist(), one.loads[:, 4].round(2),
                  [(round(a.x / DEPTH, 2), round(a.y / DEPTH, 2)) for a in (one.load, *one.load.others)],
                  one.ratio.round(1), f"misfit {one.load.misfit:.2g}", one.load.left_out,
                  np.argwhere(one.false).tolist())  # fmt: skip
    print(report(trials))


if __name__ == "__main__":
    main()
