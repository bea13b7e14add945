"""Genes: 19 numbers a template."""

import pytest

from cnnsim.formats.gene import read_gene
from cnnsim.library.imported import plain
from cnnsim.support import Diagnostics

GENE = "-1 " + " ".join(map(str, range(1, 10))) + " " + " ".join(map(str, range(11, 20)))


@pytest.mark.parametrize(
    "text", [GENE, GENE.replace(" ", ", "), GENE.replace(" 11", "\n# A\n11"), f"% z b a\n{GENE}\r\n"]
)
def test_a_gene_is_z_then_b_then_a(text: str) -> None:
    (imported,) = read_gene(text.encode(), "g", Diagnostics("g"))
    assert plain(imported.network, "").z == -1
    assert plain(imported.network, "").B.tolist() == [[1, 2, 3], [4, 5, 6], [7, 8, 9]]
    assert plain(imported.network, "").A.tolist() == [[11, 12, 13], [14, 15, 16], [17, 18, 19]]


def test_several_genes_one_a_line() -> None:
    assert [one.name for one in read_gene(f"{GENE}\n{GENE}".encode(), "G", Diagnostics("g"))] == ["g-1", "g-2"]


@pytest.mark.parametrize("text", ["1 2 3", GENE + " 4", GENE.replace("19", "x"), ""])
def test_wrong_genes(text: str) -> None:
    report = Diagnostics("g")
    assert read_gene(text.encode(), "g", report) == []
    assert report.failed
