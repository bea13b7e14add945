"""Texts of new template and program files: commented and valid."""

from cnnsim.library.write import toml_value
from cnnsim.support import InputError

TEMPLATE = """# A template: dx/dt = -x + A*y + B*u + z, y = clip(x, -1, 1). Black is +1, white is -1.
# As it stands: the edges of black objects. templates/README.md has all keys.
name = {name}
summary = "Black pixels that touch a white 8-neighbour stay black; all else turns white."
reference = "where the numbers come from"
tags = ["binary"]

# Entry (k, l) weighs the neighbour at that offset, a correlation: the top row is the northern neighbours.
A = [[0, 0, 0], [0, 1, 0], [0, 0, 0]]                # feedback, of outputs; more than 1 in the middle remembers x(0)
B = [[-1, -1, -1], [-1, 8, -1], [-1, -1, -1]]        # control, of the input
z = -1                                               # bias

input = "picture"               # u: "picture", "none", or a number from -1 to 1
initial_state = "any"           # x(0): "picture", "given" (a second picture), "any" (no matter), or a number
boundary = {{ fixed = -1 }}       # virtual cells around the grid; or "zero-flux", or "periodic"
duration = "settled"            # or a number of time constants

# Work out an example by hand: "#" is black, "." is white. `cnnsim show` draws it, tests and `robust` use it.
[[example]]
input = [
  ".......",
  ".#####.",
  ".#####.",
  ".#####.",
  ".......",
]
output = [
  ".......",
  ".#####.",
  ".#...#.",
  ".#####.",
  ".......",
]
"""

PROGRAM = """# A program: names its memories, and lists its steps.
# As it stands: the rim of black objects, and how many pixels it has. templates/programs/README.md lists the steps.
name = {name}
summary = "The rim of black objects: the pixels that an erosion takes away."
reference = "where it comes from"

lam = []                            # analog planes, of real numbers
llm = ["picture", "inner", "rim"]   # logic planes: anything above 0 is black
wire = ["pixels"]                   # registers of whole numbers
inputs = ["picture"]                # given at each run: --input picture=scan.png
outputs = ["rim", "pixels"]         # given back
# keep = {{ rim = -1 }}               # planes that survive from run to run, and what they start from
parameters = {{ rounds = 1 }}         # numbers that a caller may replace: --set rounds=2

step = [
  {{ copy = "picture", to = "inner" }},
  {{ repeat = "rounds", do = [
    {{ template = "erosion-square", input = "inner", to = "inner" }},      # a template of the library
  ] }},
  {{ logic = "p-and-not-q", of = ["picture", "inner"], to = "rim" }},
  {{ wire = "count", of = "rim", to = "pixels" }},
]

# [templates]                       # templates of its own, for steps: {{ template = "mine", ... }}
# mine = {{ A = [[1]], B = [[1, 1, 1], [1, 1, 1], [1, 1, 1]], z = -8, boundary = {{ fixed = -1 }} }}
"""


def new_text(kind: str, name: str) -> str:
    """Return the text of a new file of the ``kind`` "template" or "program".

    Raises:
        InputError: another kind.
    """
    texts = {"template": TEMPLATE, "program": PROGRAM}
    if kind not in texts:
        raise InputError(f"kind {kind!r}; {' or '.join(texts)} wanted")
    return texts[kind].format(name=toml_value(name))
