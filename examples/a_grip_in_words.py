"""A grip in words: a scene of two fingers is run through the pipeline, and the events of one finger are printed."""

from pathlib import Path

import tactile

SCENE = Path(__file__).parent / "scenes" / "grip.toml"


def main() -> None:
    """Print the events of the left finger and see how far the object slipped."""
    left = [event for event in tactile.run(SCENE).events if event.finger == "left"]
    for event in left:
        print(f"{event.t:5.2f} s  {event.arrows}  {event.words}")
    kinds = [event.kind for event in left]
    assert kinds.count("contact") == kinds.count("release") == 1
    (length,) = (event.data["length_m"] for event in left if event.kind == "slip")
    assert abs(float(length) - 0.5e-3) < 1e-6  # the scene's contact point goes from y = -0.3 to 0.2 mm


if __name__ == "__main__":
    main()
