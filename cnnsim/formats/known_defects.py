"""Published templates that are known not to do what they say, by the name of their file: found by simulation.

Where the library has the corrected template, `defects.compare` finds the difference; this table is for the rest.
"""

KNOWN: dict[str, str] = {
    **dict.fromkeys(
        ("DEADENDH", "DEADENDV"),
        "both files are the same, and with z = -5.8 the output is white for every neighbourhood; black with at most "
        "one black neighbour wants a z between -4 and -3.5 with the picture as initial state",
    ),
    **dict.fromkeys(
        ("PROP1", "PROP2"),
        "without a CURRENT nothing moves: the library's trigger-wave (z > 0) and trigger-wave-white (z < 0) do",
    ),
    **dict.fromkeys(
        (f"CNTR{k}" for k in range(1, 9)),
        "run until it settles this coupled centre point template peels past the centre; use center-point-1 to -8",
    ),
    "CENTER": "run until they settle these coupled templates peel past the centre; use center-point-1 to -8",
    **dict.fromkeys(
        ("T1_RACC3", "T2_RACC3", "T3_RACC3", "T4_RACC3", "TX_RACC3", "TX_RACC5", "TX_HCLC"),
        "learned texture template without a running time; its task could be reproduced in part, at a time of 6 to 10",
    ),
    **dict.fromkeys(("PARITY", "MAJVOT2"), "with the functions as printed it does not do what its header says"),
    "HISTOGRAM": "works in discrete time with a black west border only; in continuous time it stalls half-way",
    "HISTOGR": "works in discrete time with a black west border only; in continuous time it stalls half-way",
    "CONCCONT": "works in discrete time only; in continuous time its rings are distorted",
    **dict.fromkeys(
        ("HERRING", "HERRING1", "HERRING2", "HERRING3"), "never settles; read its output after 2 to 8 time constants"
    ),
    "LIFE_1L": 'wants the piecewise linear output: cell = { model = "discrete-time", characteristic = "clip" }',
    "TRACE": "critical: a visited cell has a drive of exactly 0 in layer 2; z = 2.5 there would hold it",
    "GLOB_CONN": "does not delete exactly the marked object; use connectivity",
    **dict.fromkeys(
        ("FUZZY", "MTYPE", "MTYPE0", "MTYPE1", "BPF", "TRW", "THRESAD"), "its task is not known well enough"
    ),
    **dict.fromkeys(
        (f"SKL{k}" for k in range(1, 9)), "the loop of eight does not keep the topology; use skeleton-1 to -8"
    ),
}
