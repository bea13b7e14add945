"""What the plan saves: how a template is computed and why, and the same result without any saving."""

import numpy as np

from cnnsim import explain, library, run


def main() -> None:
    """Fill holes with and without the savings of the plan."""
    picture = np.where(np.random.default_rng(1).random((64, 64)) < 0.45, 1.0, -1.0)
    found = explain(library.load("hole-filler"), picture)
    print(found)
    fast = run("hole-filler", picture)
    slow = run("hole-filler", picture, without=["sparse taps", "blocking", "sleep"])
    assert found.guaranteed.time is not None
    assert fast.t <= found.guaranteed.time
    assert np.array_equal(fast.y, slow.y)


if __name__ == "__main__":
    main()
