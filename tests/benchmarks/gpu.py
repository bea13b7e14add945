"""Tests and speed of the OpenCL backend on a GPU, with installed peers: `make gpu`."""

import json
import os
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import asdict
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import click
import numpy as np

from cnnsim import Template, UniversalMachine, fixed, library, load_program
from cnnsim.backends.opencl.backend import OpenCLBackend
from cnnsim.backends.opencl.device.devices import choose_device, devices, type_of
from cnnsim.support import InputError
from cnnsim.task import make_task
from tests.benchmarks import peers

ROOT = Path(__file__).parents[2]
SUBSET = "opencl and (steps or mask or batch or layers or delay or product or discrete or closed or tanh or range)"
"""The conformance cases: each text of kernels in both dtypes, the fewest builds."""
NINE = np.arange(1, 10).reshape(3, 3) * 0.03 * np.array([[1, -1, 1], [-1, 1, 1], [1, 1, -1]])
H, STEPS = 0.1, 100


def best(work: Callable[[], object], most: float = 1.0) -> float:
    """Return the shortest time of some work [s], repeated for a second, after one run that compiles."""
    work()
    times, since = list[float](), time.perf_counter()
    while (
        not times or (len(times) < 3 and times[0] < most) or (time.perf_counter() - since < most and len(times) < 200)
    ):
        begin = time.perf_counter()
        work()
        times.append(time.perf_counter() - begin)
    return min(times)


def dense(backend: OpenCLBackend, shape: tuple[int, ...], steps: int = STEPS) -> dict[str, Any]:
    """Nine general taps, Euler, a given number of steps; JAX on the same device where it is installed."""
    rng = np.random.default_rng(1)
    x = rng.uniform(-1, 1, shape).astype(np.float32)
    task = make_task(Template(NINE), state=x, boundary=fixed(0.0), duration=steps * H, scheme="euler", step=H)
    plane = backend.load(x, "lam")

    def run() -> None:
        backend.transient(task.plan, plane, None)  # it reads whether the end is finite, so it waits

    seconds, cells = best(run), x.size * steps
    row: dict[str, Any] = {"work": f"nine taps, {'x'.join(map(str, shape))}, {steps} steps", "seconds": seconds}
    row |= {"Gcs": 1e-9 * cells / seconds, "us a step": 1e6 * seconds / steps}
    if find_spec("jax") and len(shape) == 2:
        peer = peers.jax(x, np.zeros_like(x), NINE.astype(np.float32), H, steps)
        row["of JAX"] = best(peer) / seconds
    return row


def settled(backend: OpenCLBackend, side: int) -> dict[str, Any]:
    """The hole filler on a random picture, until it settles."""
    picture = np.where(np.random.default_rng(1).random((side, side)) < 0.4, 1.0, -1.0)
    entry = library.load("hole-filler")
    task = make_task(entry.network, **entry.task(picture))
    return {"work": f"hole-filler, {side}x{side}", "seconds": best(lambda: task.start(backend))}


def logic(backend: OpenCLBackend, side: int) -> dict[str, Any]:
    """One logic function of two packed planes."""
    p, q = (backend.load(np.random.default_rng(i).random((side, side)) < 0.5, "llm") for i in (1, 2))

    def run() -> None:
        for _ in range(20):
            backend.logic(6, p, q)
        backend._context.wait()

    seconds = best(run) / 20
    return {"work": f"logic, {side}x{side}", "seconds": seconds, "GB/s": 3e-9 * side * side / 8 / seconds}


def program(backend: OpenCLBackend, name: str, frames: int) -> dict[str, Any]:
    """A program on 8 x 8 frames from and to the host."""
    loaded, shape = load_program(name), (frames, 8, 8) if frames > 1 else (8, 8)
    machine, rng = UniversalMachine(backend), np.random.default_rng(1)
    planes = {plane: rng.uniform(-1, 1, shape).astype(np.float32) for plane in loaded.inputs}
    seconds = best(lambda: machine.run(loaded, **planes))
    return {"work": f"{name}, {frames} frames of 8x8", "seconds": seconds, "us a frame": 1e6 * seconds / frames}


def table(rows: list[dict[str, Any]]) -> str:
    """Return rows as a table in Markdown."""
    names = list(dict.fromkeys(name for row in rows for name in row))
    lines = [" | ".join(names), " | ".join("---" for _ in names)]
    for row in rows:
        values = (row.get(name, "") for name in names)
        lines.append(" | ".join(v if isinstance(v, str) else f"{v:.4g}" for v in values))
    return "".join(f"| {line} |\n" for line in lines)


@click.command()
@click.option("--any-device", is_flag=True, help="Try the command on a device that is no GPU, with small sizes.")
@click.option("-o", "folder", default="out/gpu", show_default=True, type=click.Path(path_type=Path))
def main(any_device: bool, folder: Path) -> None:
    """Run a subset of the tests on the default OpenCL device, then the table of speeds."""
    is_gpu = type_of(choose_device()) == "gpu"
    if not (is_gpu or any_device):
        raise InputError("the default OpenCL device is no GPU; set CNNSIM_DEVICE, or --any-device wanted")
    facts = asdict(next(device for device in devices() if device.chosen))
    print("\n".join(f"{key}: {value}" for key, value in facts.items()), flush=True)
    tests = [f"tests/backends/{name}" for name in ("conformance/test_cases.py", "opencl/test_counts.py")]
    command = [sys.executable, "-m", "pytest", "-p", "no:cacheprovider", "-k", f"({SUBSET}) or frame", *tests]
    failed = subprocess.run(command, cwd=ROOT, env={**os.environ, "PYTHONPATH": str(ROOT)}, check=False).returncode
    sides = (512, 2048, 8192, 16384) if is_gpu else (256,)
    backend, rows, since = OpenCLBackend("float32"), list[dict[str, Any]](), time.perf_counter()
    jobs: list[Callable[[], dict[str, Any]]] = [lambda s=s: dense(backend, (s, s)) for s in sides]  # type: ignore[misc]
    jobs += [lambda: dense(backend, (64, 64), 1000), lambda: dense(backend, (1056 if is_gpu else 8, 32, 32), 1000)]
    jobs += [lambda s=s: settled(backend, s) for s in ((64, 1024, 4096) if is_gpu else (64,))]  # type: ignore[misc]
    jobs += [lambda: logic(backend, 4096 if is_gpu else 512)]
    for name in ("contact-blob", "slip-front"):
        for frames in (1, 1000, 100_000) if is_gpu else (1, 100):
            jobs.append(lambda n=name, f=frames: program(backend, n, f))  # type: ignore[misc]
    for number, job in enumerate(jobs, 1):
        rows.append(job())
        print(f"{number}/{len(jobs)}, {time.perf_counter() - since:.0f} s: {rows[-1]['work']}", flush=True)
    folder.mkdir(parents=True, exist_ok=True)
    found = {"device": facts, "tests": "passed" if not failed else "failed", "rows": rows}
    (folder / "gpu.json").write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")
    text = f"{facts['name']}, {facts['platform']} {facts['version']}; tests {found['tests']}\n\n{table(rows)}"
    (folder / "gpu.md").write_text(text, encoding="utf-8")
    print(text + f"-> {folder}/gpu.md, {folder}/gpu.json")
    sys.exit(failed)


if __name__ == "__main__":
    main()
