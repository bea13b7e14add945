"""Smoothing that keeps edges: a non-linear template that reduces small differences and keeps large ones."""

import numpy as np

from cnnsim import Table, Template, Term, run_transient


def main() -> None:
    """Smooth a noisy step."""
    even_out = Table("linear", at=(-2, -0.4, -0.2, 0.2, 0.4, 2), values=(0, 0, -0.2, 0.2, 0, 0))
    around = [[0, 1, 0], [1, 0, 1], [0, 1, 0]]
    template = Template([[1]], terms=[Term(around, "x_kl - x_ij", even_out)])
    noise = np.random.default_rng(1).normal(0, 0.04, (24, 24))
    step = np.where(np.arange(24) < 12, -0.5, 0.5) + noise
    end = run_transient(template, state=step, duration=10.0).x
    left, right = end[:, :12], end[:, 12:]
    assert max(left.std(), right.std()) < 0.1 * noise.std()
    assert abs(right.mean() - left.mean() - 1) < 0.01
    print(f"noise {noise.std():.3f} -> {left.std():.4f}, step {right.mean() - left.mean():.3f}")


if __name__ == "__main__":
    main()
