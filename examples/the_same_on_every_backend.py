"""The same on every backend: plain NumPy, compiled loops, and OpenCL where there is a device."""

import numpy as np

from cnnsim import devices, run


def main() -> None:
    """Halftone a grey ramp on each backend and compare; a symmetric ramp would have ties that rounding decides."""
    ramp = np.add.outer(np.linspace(-0.1, 0.1, 32), np.linspace(-0.9, 0.9, 48))
    backends = ["reference", "cpu", *(["opencl"] if devices() else [])]
    outputs = {name: run("halftone-3x3", ramp, backend=name).y for name in backends}
    for name, y in outputs.items():
        same = np.mean((y > 0) == (outputs["reference"] > 0))
        print(f"{name:<10} {np.mean(y > 0):.3f} black, {same:.1%} as the reference")
        assert same == 1
    assert abs(np.mean(outputs["cpu"] > 0) - 0.5) < 0.02


if __name__ == "__main__":
    main()
