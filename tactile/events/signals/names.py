"""Names of the signal planes and of the scalar signals of a finger, in their order."""

PLANES = ("shear_x", "shear_y", "pressing", "drawn_x", "drawn_y", "share", "firmness")
LEVELS = (
    "loaded",
    "rising",
    "falling",
    "loosened",
    "balanced",
    "unsteady",
    "settled",
    "driven",
    "dropping",
    "yielding",
    "sticking",
    "turning",
    "turning_back",
    "outweighs",
    "sheared",
)
RISING, DROPPING = LEVELS.index("rising"), LEVELS.index("dropping")
TURNING, BALANCED = LEVELS.index("turning"), LEVELS.index("balanced")
LOOSENED, SETTLED = LEVELS.index("loosened"), LEVELS.index("settled")
