"""Limits of the load fit: constants of the estimator, of its statistical tests and of the choice of a model.

Lengths are in depths, signals relative to the largest one.
"""

# the fit
STEPS = 20
"""Gauss-Newton steps at most; two or three are usual."""
CONVERGED = 0.01
"""Largest reduction of chi^2 by the last step, in variances of one signal."""
ROUNDING = 1e-26
"""A share of the signals' energy that is rounding."""
DAMPING, STIFF = 1e-3, 1e6
"""First damping of a failed step, and the damping at which a fit gives up."""
UNOBSERVABLE = 1e9
"""Weight of the equation that keeps shear at zero where the taxels do not measure it."""
REACH, ALL_TAXELS = 4.0, 100
"""Of more than `ALL_TAXELS` taxels those within `REACH` of a load are fitted: the others read 1 % of it at most."""

# where the fit starts
VOTERS, SEEDS = 16, 3
"""Number of strongest taxels whose answers are averaged, and of those among them whose answers start an average."""
SAME = 0.1
"""Places nearer to each other than this are one place."""
FEWEST = 4
"""With fewer taxels several places fit nearly as well; no answer is taken without the tests in Python."""

# noise
NOISE_FROM = 25
"""Number of taxels from which unknown noise is estimated from the residuals."""
USUAL_NOISE = 0.01
"""Noise assumed where it is unknown and the residuals are smaller."""
SMALL_SHARE = 2.5e-3
"""Share of the energy in the residuals (a misfit of 5 %) below which unknown noise is not estimated."""
NOISE_ERROR = 0.03
"""Relative error of the known noise: it is measured in few frames, and taxels differ."""
CHANCE, NOT_CHANCE = 2.0, 3.0
"""Standard deviations of chi^2 that noise may add, and from which the excess is not noise (1 frame in 300)."""

# tests of single readings
STRONGEST = 4
"""Taxels whose readings are tested: the place does not depend on one reading of a weaker taxel."""
SLIGHT_MISFIT, FEW_FREE = 2e-3, 6
"""Where the noise is unknown, false readings are tested from this misfit on with more degrees of freedom than this."""
NOTICED, BY_CHANCE = 3.5, 0.02
"""Residual of a false reading in standard deviations of known noise (exceeded by noise in 1 frame of 200); share of the
frames in which unknown noise gives one of the tested readings such a residual."""
LIKELY = 0.5
"""Bayes factor from which a clipped, dead or wide alternative counts; they have fewer parameters than any false
reading: one largest reading, one sign, one radius."""
WIDEST = 1.6
"""Largest likely width, over that of the ring in `width`: a ball with a contact radius of one depth."""
HIDDEN = 1e-6
"""Least visible part of an error in a reading; less is rounding."""
HIDES = 0.9
"""Part of an error in a reading that the load absorbs, from which on the linear estimate is not reliable."""
FALSE_SIGMAS, FALSE_TIMES = 6.0, 20.0
"""A reading is false if chi^2 without it is noise and smaller by `FALSE_SIGMAS`^2 variances; with unknown noise, if the
residual variance is smaller by `FALSE_TIMES`. The same factor applies to clipped readings."""
CLIPPED_SIGMAS, NEAR_END, EQUAL = 5.0, 1e-3, 1e-12
"""Deviations from which a reading is clipped; relative distances of readings clipped at one end, and of equal ones."""

# tests of the model
DOUBT, PATCH, POINT = 0.05, 0.1, 0.25
"""Misfits from which other models are tried, from which several loads are, and beyond which there is no point load: a
tip of half a depth leaves 0.1."""
UNSURE, MISLED = 0.5, 1.0
"""Standard deviations of the place from which the place is ambiguous: from the residuals alone, and with the false
readings and widths that they do not exclude."""
RIVAL, RIVAL_SIGMAS = 3.0, 6.0
"""Ratio of misfits beyond the noise, and standard deviations of known noise, below which a second place makes the
answer ambiguous."""
RIVALS = 4.0
"""Ratio of residual variances below which two models are both possible."""
FOREIGN_SHARE, FOREIGN_SIGMAS, FOREIGN_RATIO, FOREIGN_MEDIAN = 0.01, 6.0, 2.0, 30.0
"""Residual of a taxel out of reach that shows another load: as a share of the largest signal, in standard deviations,
over the signal of the fitted loads, and (squared) over that of the median taxel."""
LARGE_PAD, PEAK = 16, 0.05
"""Taxels a side above which every peak starts a load, and the least height of a peak over the highest."""
SECOND_APART, SECOND_SHARE, SECOND_TIMES = 1.2, 0.5, 30.0
"""Least distance of a second load, the share of chi^2 that it explains to first order, and the factor by which it must
reduce the variance if the rest is not noise."""
LOADS, LOADS_APART = 4, 2.0
"""Largest number of loads fitted on small pads; least distance of two loads, nearer ones are one patch."""
