"""Which detectors watch every finger. Adding one is one file under ``templates/programs/touch``, and its name here."""

SHIPPED = ("contact", "tangential", "slip")
"""In the order in which they run: a later one may have the outputs of an earlier one as inputs."""
