"""Small grids, many frames: a program with the load inverse, the events of a finger, and the inverse alone."""

import time
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from cnnsim.network import ZERO_FLUX, Template
from cnnsim.operations.logic import function_number
from cnnsim.program.machine import UniversalMachine
from cnnsim.program.program import CellwiseStep, LogicStep, Program, TemplateStep, WireStep
from tactile import open_source
from tactile.core.source import FrameStream
from tactile.inverse.taxel import STRAIN_INVERSE
from tactile.pipeline import run, warm_up
from tactile.settings import Settings
from tests.benchmarks.dense import backends
from tests.benchmarks.race import Row, race
from tests.fuzz.two_ends import FINGER, SCENE

PARAMETERS = (0.002, 2.5e5, 1e-6, 1.0)
"""Depth [m], modulus [Pa], floor [strain], pressing."""


def five_steps() -> Program:
    """Loads from strains, contact where the force is above a threshold, without lone taxels, new contact, its size."""
    strains, loads = ("u_xz", "u_yz", "u_zz"), ("dx", "dy", "force", "validity")
    contact = Template(2, 5.0, -1.0, "threshold")
    grown = Template(1, [[0, 1, 0], [1, 1, 1], [0, 1, 0]], 4.0, "dilation-cross")
    memory = dict.fromkeys((*strains, *loads), "lam") | dict.fromkeys(("on", "near", "fresh"), "llm")
    steps = (
        CellwiseStep("step 1", STRAIN_INVERSE, strains, loads, PARAMETERS),
        TemplateStep("step 2", contact, ZERO_FLUX, "settled", "force", 0.0, None, None, "on"),
        TemplateStep("step 3", grown, ZERO_FLUX, "settled", "on", 0.0, None, None, "near"),
        LogicStep("step 4", function_number("p-and-not-q"), "near", "on", "fresh"),
        WireStep("step 5", "count", "fresh", "size"),
    )
    memory["size"] = "wire"
    return Program("five steps", "", memory, strains, ("force", "near", "size"), {}, steps)  # type: ignore[arg-type]


def frames(rounds: int) -> list[Row]:
    """8 x 8 taxels: one frame at a time, and 100 000 frames in a batch."""
    rng, machine, program = np.random.default_rng(0), UniversalMachine("cpu"), five_steps()
    batch = {name: rng.normal(0, 1e-3, (100_000, 8, 8)).astype(np.float32) for name in program.inputs}
    single = [{name: batch[name][i] for name in program.inputs} for i in range(2000)]
    seconds: list[float] = []
    for _ in range(rounds):
        for frame in single:
            start = time.perf_counter()
            machine.run(program, **frame)
            seconds.append(time.perf_counter() - start)
    median, late = np.percentile(seconds[2000:] or seconds, [50, 99])
    whole = race({"batch": lambda: machine.run(program, **batch)}, rounds)["batch"]
    return [
        Row("8x8, five steps, a frame", "cpu", 1e6 * float(median), "us", "median < 60"),
        Row("8x8, five steps, a frame", "cpu", 1e6 * float(late), "us", "99 % < 250"),
        Row(
            "8x8, 100 000 frames at once",
            "cpu",
            100 / whole,
            "kHz",
            ">= 20 x one by one",
            {"one by one": 1e5 * float(median) / whole},
        ),
    ]


def events(rounds: int) -> list[Row]:
    """One finger of 8 x 8, noisy, from frame to events: processor time of a frame, which two share half a core for."""
    rows, rng = [], np.random.default_rng(0)
    with TemporaryDirectory() as folder:
        scene = Path(folder) / "scene.toml"
        scene.write_text(SCENE.format(hz=1000, seconds=4.0) + FINGER.format(name="tip", rows=8, cols=8))
        source = open_source(scene)
        found = list(source)
    for quantity, to_quantity, noise in (("strain", 1.0, 2e-5), ("force", 50.0 * np.array([1, 1, -1]), 2e-3)):
        array = replace(source.arrays[0], quantity=quantity)  # type: ignore[arg-type]  # both are quantities
        frames = [replace(f, values=f.values * to_quantity + noise * rng.normal(size=(8, 8, 3))) for f in found]
        stream = FrameStream(quantity, (array,), source.modulus, len(frames), frames)
        warm_up((array,), source.modulus, Settings())
        best = np.inf
        for _ in range(rounds):
            begun = time.process_time()
            run(stream, Settings(tare="auto"), [])
            best = min(best, time.process_time() - begun)
        rows.append(Row(f"8x8 of {quantity}, a frame to events", "cpu", 1e6 * best / len(frames), "us", "< 200"))
    return rows


def inverse(triad: float, rounds: int) -> list[Row]:
    """The load inverse on ten million taxels; on OpenCL memory of planes is used again."""
    operation = STRAIN_INVERSE
    assert operation.compiled is not None
    kernel, n, rng = operation.compiled(), 10_000_000, np.random.default_rng(0)
    planes = [rng.normal(0, 1e-3, n).astype(np.float32) for _ in range(3)] + [np.empty(n, np.float32) for _ in range(4)]

    best = race({"kernel": lambda: kernel(*planes, *PARAMETERS)}, rounds)["kernel"]
    rate = 1e-9 * 28 * n / best
    ratios = {"triad": rate / triad}
    rows = [Row("load inverse, 1e7 taxels", "cpu", rate, "GB/s", ">= 0.5 of triad", ratios, f"{1e3 * best:.1f} ms")]
    if opencl := backends().get("opencl"):
        loaded = [opencl.load(plane.reshape(2500, 4000), "lam") for plane in planes[:3]]
        nothing = opencl.load(np.zeros((1, 1)), "llm")

        def on_device() -> None:
            opencl.cellwise(operation, loaded, PARAMETERS)
            opencl.count(nothing)  # waits for it

        best = race({"kernel": on_device}, rounds)["kernel"]
        rate = 1e-9 * 28 * n / best
        note = f"{1e3 * best:.1f} ms"
        rows.append(
            Row("load inverse, 1e7 taxels", "opencl", rate, "GB/s", ">= 0.5 of triad", {"triad": rate / triad}, note)
        )
    return rows
