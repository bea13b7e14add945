"""What has moved: an input that changes with time, and a term that remembers it."""

import numpy as np

from cnnsim import Frames, Template, Term, run_transient


def main() -> None:
    """Find the cells that an object has covered since the frame before."""
    frames = []
    for col in (4, 7):
        frame = -np.ones((12, 20))
        frame[3:9, col : col + 6] = 1
        frames.append(frame)
    newly = Template([[1]], B=[[1]], z=-1, terms=[Term([[-1]], "u_kl", delay=10)])  # u now and not u then
    end = run_transient(newly, state=-np.ones((12, 20)), input=Frames(frames, period=10), duration=20)
    assert (end.y > 0).sum() == 6 * 3
    assert (end.y > 0)[3:9, 10:13].all()
    print(f"{(end.y > 0).sum()} cells are newly covered")


if __name__ == "__main__":
    main()
