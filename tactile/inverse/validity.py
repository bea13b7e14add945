"""Validity of a located load: whether the inverse has an answer, and how far from the taxel it lies."""

from enum import IntEnum

FAR = 1e-6
"""Ratio of the smaller to the larger signal below which the load is a million depths away: no finite answer."""


class Validity(IntEnum):
    """Validity of a taxel's answer or of a load; planes carry it as a float."""

    NO_LOAD = 0
    """The largest signal is at or below the floor."""
    INSIDE = 1
    """The load is nearer than sqrt(2) depths, where u_zz has its own sign: the reliable region."""
    OUTSIDE = 2
    """The load is at sqrt(2) depths or farther."""
    AMBIGUOUS = 3
    """Two loads fit; the one with s > 0 is given."""
    INVALID = 4
    """A signal is NaN or infinite, or no load at a finite distance fits."""
    NOT_ONE = 5
    """The signals of all taxels fit no point load, nor a few that are well apart."""
