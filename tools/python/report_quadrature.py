"""Quadrature: the error of rules against kernel values, for one nearly singular integral."""

import sys
from pathlib import Path

from command import output_of
from report_context import Context, Section, image

CAPTION = (
    "Relative error against kernel values at distances 0.1 to 1e-12 for one triangle: Gauss, the paper's odd-power map "
    "(3.33)-(3.35), the sinh map, the closed form along rays, and polyrad. Table 3.1 of the paper is in the section on the paper."
)


def section(ctx: Context) -> Section:
    data, is_there = ctx.place("quadrature", "quadrature.csv")
    if not is_there:
        data.write_text(output_of(ctx.polyrad.parent / "tests/bench_quadrature"))
    path = ctx.folder / "quadrature" / "quadrature.svg"
    path.parent.mkdir(parents=True, exist_ok=True)
    plot = Path(__file__).parent / "plot_quadrature.py"
    output_of(sys.executable, plot, data, "-o", path)
    return Section("Quadrature", image(path, CAPTION), [path])
