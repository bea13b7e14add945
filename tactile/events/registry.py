"""Shipped detectors. A new one is one file in ``templates/programs/touch``, and its name here."""

SHIPPED = ("contact", "tangential", "slip")
"""In running order: a later detector may read the outputs of an earlier one."""
