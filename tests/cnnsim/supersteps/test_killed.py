"""Runs that are killed and resumed, on worker processes and on a Dask cluster."""

import json
import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest

import cnnsim
from cnnsim.support import InputError
from cnnsim.workers import open_workers
from tests.kits.paths import ROOT

pytestmark = pytest.mark.slow

PICTURE = np.where(np.random.default_rng(3).random((300, 300)) < 0.6, 1.0, -1.0)
CALL = [
    "-m",
    "cnnsim",
    "run",
    "averaging-threshold",
    "p.npy",
    "--time",
    "12",
    "--block",
    "64",
    "--workers",
    "2",
    "-o",
    "y.npy",
]
ENVIRONMENT = {**os.environ, "PYTHONPATH": str(ROOT)}


def start(folder: Path, *more: str, environment: Mapping[str, str] = ENVIRONMENT) -> subprocess.Popen[str]:
    np.save(folder / "p.npy", PICTURE.astype(np.float32))
    return subprocess.Popen(
        [sys.executable, *CALL, "--store", "store", *more], cwd=folder, env=environment, text=True,
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, start_new_session=True,
    )  # fmt: skip


def supersteps(folder: Path) -> int:
    try:
        return int(json.loads((folder / "store" / "zarr.json").read_text())["attributes"]["record"]["superstep"])
    except (OSError, KeyError):
        return 0


def wait_for_superstep(folder: Path, run: "subprocess.Popen[str]", count: int) -> None:
    until = time.monotonic() + 100
    while supersteps(folder) < count and run.poll() is None:
        assert time.monotonic() < until
        time.sleep(0.02)


def whole() -> np.ndarray:
    return np.asarray(cnnsim.run("averaging-threshold", PICTURE, duration=12.0).y)


def test_a_run_that_is_killed_resumes_from_its_last_superstep(tmp_path: Path) -> None:
    run = start(tmp_path)
    wait_for_superstep(tmp_path, run, 2)
    os.killpg(run.pid, signal.SIGKILL)
    run.communicate()
    kept = supersteps(tmp_path)
    assert kept >= 2
    again = start(tmp_path)
    out, errors = again.communicate(timeout=200)
    assert again.returncode == 0, errors
    assert "300 x 300 cells, t = 12" in out
    assert np.load(tmp_path / "y.npy").tobytes() == whole().tobytes()
    assert supersteps(tmp_path) > kept


def done(folder: Path) -> int:
    try:
        return int(json.loads((folder / "blocks" / "zarr.json").read_text())["attributes"]["record"]["done"])
    except (OSError, KeyError):
        return 0


def wait_until_done(folder: Path, run: "subprocess.Popen[str]", count: int) -> None:
    until = time.monotonic() + 100
    while done(folder) < count and run.poll() is None:
        assert time.monotonic() < until
        time.sleep(0.01)


def test_a_program_survives_a_killed_worker_and_resumes_when_all_are_killed(tmp_path: Path) -> None:
    np.save(tmp_path / "p.npy", PICTURE[:64, :70] > 0)
    call = "program size-sorting --input picture=p.npy --block 24 --workers 2 --store blocks -o out"

    def started() -> "subprocess.Popen[str]":
        return subprocess.Popen(
            [sys.executable, "-m", "cnnsim", *call.split()], cwd=tmp_path, env=ENVIRONMENT, text=True,
            stdout=subprocess.PIPE, stderr=subprocess.PIPE, start_new_session=True,
        )  # fmt: skip

    run = started()
    wait_until_done(tmp_path, run, 5)
    children = Path(f"/proc/{run.pid}/task/{run.pid}/children")
    workers = [
        int(child) for child in (children.read_text() if children.exists() else "").split()
        if b"spawn_main" in Path(f"/proc/{child}/cmdline").read_bytes()
    ]  # fmt: skip
    for worker in workers[:1]:
        os.kill(worker, signal.SIGKILL)
    wait_until_done(tmp_path, run, 8)
    assert run.poll() is None, run.communicate()
    os.killpg(run.pid, signal.SIGKILL)
    run.communicate()
    kept = done(tmp_path)
    again = started()
    out, errors = again.communicate(timeout=200)
    assert again.returncode == 0, errors
    assert done(tmp_path) > kept >= 8
    whole = cnnsim.run_program("size-sorting", picture=PICTURE[:64, :70] > 0)
    for name, value in whole.items():
        assert f"{name}: {int(value.sum())} black cells" in out
        shown = cnnsim.read_picture(tmp_path / "out" / f"{name}.png") > 0
        assert np.array_equal(shown, value)


def certificate(folder: Path) -> dict[str, str]:
    """Make a key and a certificate that signs itself; return the settings of Dask that name them."""
    key, signed = folder / "key.pem", folder / "cert.pem"
    subprocess.run(
        ["openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256", "-nodes", "-days", "1",
         "-subj", "/CN=cnnsim", "-keyout", str(key), "-out", str(signed)], check=True, capture_output=True,
    )  # fmt: skip
    tls = "DASK_DISTRIBUTED__COMM__TLS__"
    of_a_role = {f"{tls}{role}__{kind}": str(path) for role in ("CLIENT", "SCHEDULER", "WORKER")
                 for kind, path in (("CERT", signed), ("KEY", key))}  # fmt: skip
    return {f"{tls}CA_FILE": str(signed), "DASK_DISTRIBUTED__COMM__REQUIRE_ENCRYPTION": "True", **of_a_role}


@pytest.mark.skipif(shutil.which("openssl") is None, reason="openssl makes the certificate of the cluster")
def test_a_dask_cluster_refuses_strangers_loses_a_worker_and_then_its_scheduler(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("distributed")
    known = {**ENVIRONMENT, **certificate(tmp_path)}
    file = tmp_path / "scheduler.json"
    dask = [sys.executable, "-m", "dask"]
    quiet = {"env": known, "stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL, "cwd": tmp_path}
    head = subprocess.Popen(
        [
            *dask,
            "scheduler",
            "--host",
            "tls://127.0.0.1",
            "--port",
            "0",
            "--no-dashboard",
            "--scheduler-file",
            str(file),
        ],
        **quiet,  # type: ignore[call-overload]  # as above
    )
    worker = [*dask, "worker", "--scheduler-file", str(file), "--nthreads", "1", "--no-nanny", "--no-dashboard"]
    crew = [subprocess.Popen(worker, **quiet) for _ in range(2)]  # type: ignore[call-overload]  # as above
    try:
        until = time.monotonic() + 60
        while not file.exists():
            assert time.monotonic() < until
            time.sleep(0.1)
        address = json.loads(file.read_text())["address"]
        assert address.startswith("tls://")
        monkeypatch.setattr("cnnsim.workers.TIMEOUT", 2.0)
        for stranger in (address, address.replace("tls", "tcp")):  # without a certificate
            with pytest.raises(InputError, match="no scheduler answers"), open_workers(f"dask={stranger}"):
                pass
        run = start(tmp_path, "--engine", f"dask={address}", environment=known)
        wait_for_superstep(tmp_path, run, 1)
        crew[0].kill()
        wait_for_superstep(tmp_path, run, 3)
        head.kill()
        _, errors = run.communicate(timeout=200)
        assert run.returncode == 2, errors
        assert "is lost; store keeps superstep" in errors
        assert "Traceback" not in errors
        kept = supersteps(tmp_path)
        again = start(tmp_path)  # with another engine
        _, errors = again.communicate(timeout=200)
        assert again.returncode == 0, errors
        assert supersteps(tmp_path) > kept
        assert np.load(tmp_path / "y.npy").tobytes() == whole().tobytes()
    finally:
        for process in (*crew, head):
            process.kill()
            process.wait()
