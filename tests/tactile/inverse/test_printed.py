"""The stable inverse and the paper's, as printed, against high precision; figures of the accuracy page."""

from tests.benchmarks.accuracy.inverse import forms


def test_the_stable_form_keeps_its_digits_where_the_printed_one_loses_them() -> None:
    worst: dict[str, float] = {}
    for row in forms():
        worst[row["way"]] = max(worst.get(row["way"], 0.0), row["error"])
    assert worst["stable, float64"] < 2e-15
    assert worst["stable, float32"] < 1e-6
    assert worst["printed, float64"] > 0.1
    assert worst["printed, float32"] > 0.1
