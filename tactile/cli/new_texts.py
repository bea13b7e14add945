"""Templates of scene files, array descriptions and detectors: every key, most of them as comments."""

SCENE = """\
# A finger is touched, pushed to the right and released. Lengths in mm, forces in N, times in s.
# Try it: change a number, take a # away, run again; tactile explain NAME.toml shows what each part does to the signal.

title      = "NAME"
rate_hz    = 200            # frames a second, for each finger
duration_s = 2.0
# seed       = 1            # of all random effects
# effects    = "auto"       # drop named effects, and compute the field more coarsely, within the tolerance
# tolerance  = 0.02         # largest error relative to the peak of the signal
# accuracy   = 1e-4         # error of the field relative to its peak; 0 for rounding, slow under wide contacts

[cover]
youngs_modulus_mpa = 2.4    # soft silicone rubber
quantity = "strain"         # what the taxels measure: "strain", "stress" or "force" [N] on the area of each
# full_scale = 0.1          # largest strain that the electronics are made for
# kind = "bump"             # a bump over every taxel (examples/scenes/bump.toml has its keys); "flat" is without

[[finger]]                  # one table for each; names are used below
name     = "finger"
rows     = 2
cols     = 2
pitch_mm = 1.5              # distance of neighbouring taxels
depth_mm = 1.5              # how deep they lie
# origin_mm = [0.0, 0.0]    # centre of the array: x to the right, y down

[[load]]                    # a force at a point; in between the rows everything changes linearly
finger = "finger"
path = [
  # t_s  x_mm  y_mm   Q_N   R_N   F_N: tangential along x and y, normal
  [0.30, 0.20, -0.30, 0.00, 0.00, 0.00],
  [0.60, 0.20, -0.30, 0.00, 0.00, 0.60],
  [1.00, 0.20, -0.30, 0.30, 0.00, 0.60],
  [1.40, 0.20, -0.30, 0.30, 0.00, 0.60],
  [1.70, 0.20, -0.30, 0.00, 0.00, 0.00],
]

# [[contact]]               # a body that presses: sphere, needle, disc, flat_punch, edge, cylinder, point or height_map
# finger    = "finger"
# shape     = "sphere"
# radius_mm = 5
# friction  = 0.6           # without it nothing slips
# path = [[0.3, 0.0, 0.0, 0.0, 0.0, 0.0], [0.8, 0.0, 0.0, 0.2, 0.0, 0.5], [1.5, 0.0, 0.0, 0.0, 0.0, 0.0]]

# [[texture]]               # a material drawn over one point: screw, smooth wood, fine textile or rasp
# finger     = "finger"
# material   = "rasp"
# speed_mm_s = 5
# force_N    = 0.3
# start_s    = 0.2
# stop_s     = 1.8

# [effect.read_noise]       # one table an effect; docs/effects.md lists all of them
# rms = 0.001               # of full scale
"""

ARRAY = """\
# Description of a device: its boards, the layout of their taxels, the conversion of their readings to frames.

title    = "NAME"
protocol = "native"         # reskin, papillarray, paxini-fast, paxini-serial, lowiek, native or csv
# baudrate = 921600         # the protocol's own unless given
youngs_modulus_mpa = 2.4    # of the cover; wanted where the quantity is strain

[[finger]]                  # one table for each board, in the order in which the wire carries them
name     = "finger"
rows     = 2
cols     = 2
pitch_mm = 1.5              # distance of neighbouring taxels
depth_mm = 1.5              # depth of the taxels under the cover; 0 for force sensors
# thickness_mm = 2.0        # of the cover over its rigid base; without it loads are located on a half-space
quantity = "strain"         # strain, stress or force: what the readings are after the gains
# origin_mm = [0.0, 0.0]    # centre of the array: x to the right, y down
# axes  = ["x", "y", "-z"]  # which of the device's axes are shear_x, shear_y and normal
# gains = [1e-5, 1e-5]      # shear, normal: quantity per unit of the wire; microtesla of magnetometers need them
#                           # (where they are unknown: quantity = "force" and depth_mm = 0.0, for tactile score)
# cells = [[0, 1], [2, 3]]  # the device's number of the chip in each cell, -1 where none is

# [thresholds]              # of events, unless the command line sets them; without them the noise decides
# dead_band     = 1e-3      # least shear that is a direction [unit of the quantity], as --dead-band
# hysteresis    = 5e-4      # a direction starts only this much above it, as --hysteresis
# contact_level = 1e-3      # least pressing at which a taxel stays in contact, as --contact-level
# sigmas = [4, 6, 3]        # the three in sigma of a taxel's noise, as --sigmas; [0, 0, 0]: fixed thresholds
# sign_code = true          # the bare signs instead of a dead band, as --sign-code
"""

DETECTOR = """\
# A detector: steps on the planes of one finger, frame by frame, and what its outputs mean. tactile planes names the
# planes; templates/programs/README.md has the steps. Run it: tactile run SCENE.toml --program NAME.toml

name    = "NAME"
summary = "At least three neighbouring taxels are pressed."
llm     = ["touch", "beside", "together"]   # logic planes, white and black
wire    = ["count", "enough"]               # registers: numbers
inputs  = ["touch"]                         # planes of the finger
outputs = ["together", "enough"]
# keep  = { together = -1 }                 # planes kept from frame to frame, and what they are at first

step = [
  { template = "beside", input = "touch", state = 0, to = "beside" },
  { logic = "and", of = ["touch", "beside"], to = "together" },
  { wire = "count", of = "together", to = "count" },
  { number = "less", of = [2, "count"], to = "enough" },
]

[templates]                                 # black where one of the eight neighbours is black
beside = { A = [[1]], B = [[1, 1, 1], [1, 0, 1], [1, 1, 1]], z = 7, boundary = { fixed = -1 } }

[[event]]                                   # one table for each kind of event
kind       = "together"
when       = "enough"                       # the register (not 0) or plane (any cell black) that is on while it lasts
taxels     = "together"                     # the taxels concerned
words      = "{taxels} of {of_taxels} taxels together"
confirm_ms = 20                             # time for which it is on before it is reported ...
release_ms = 50                             # ... and off before it ends
# direction = "load"                        # or four outputs for +x, -x, +y, -y; {direction} in the words
# sense     = ["clockwise", "anticlockwise"]  # two outputs; {sense} in the words
"""
