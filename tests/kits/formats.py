"""A .tem file like those of the published libraries."""

HOLE = """%Function:\tFills holes.
%TemLibName:\tHoleFiller
%Setting:\tInput:P, IniState:1, Boundary:Fixed(0)
neighborhood: 1
feedback:
0 1 0
1 3 1
0 1 0
control:
0 0 0
0 4 0
0 0 0
current: -1
"""
