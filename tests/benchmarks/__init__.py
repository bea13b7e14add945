"""Speed in comparison with other packages, in the same run on one machine: ``python -m tests.benchmarks``."""
