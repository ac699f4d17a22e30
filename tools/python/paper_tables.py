"""The paper's tables beside ours: numbers, and the tables as Markdown and HTML."""

import html
import json
import re
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

import paper_quadrature as quadrature
from paper_exponents import LINES, exact_and_measured, of_the_paper
from paper_mesh import place
from paper_runs import Runs, Study
from report_context import grid

PAPER = json.loads(Path(__file__).with_name("paper.json").read_text())
RHO_S2, EMISSION_S2 = np.array([0.5, 1.0, 0.25]), np.array([1.0, 0.2, 0.2])


@dataclass
class Table:
    title: str
    head: list[str]
    rows: list[list[str]]
    notes: list[str] = field(default_factory=list)

    def markdown(self) -> str:
        lines = [self.head, ["---"] * len(self.head), *self.rows]
        table = "\n".join("| " + " | ".join(row) + " |" for row in lines)
        return "\n\n".join([table, *self.notes])

    def page(self) -> str:
        """As HTML."""
        notes = "".join(f"<p>{html.escape(plain(note))}</p>" for note in self.notes)
        head = f"<h3>{html.escape(self.title)}</h3>"
        return f"{head}\n{grid(self.head, self.rows)}\n{notes}"


def plain(markdown: str) -> str:
    return re.sub(r"\*\*|`", "", markdown)


def number(x: float) -> str:
    """2.83248e-2, as the paper has digits."""
    mantissa, exponent = f"{x:.5e}".split("e")
    return f"{mantissa}e{int(exponent)}"


def percent(ours: float, printed: float) -> str:
    return f"{100 * (ours / printed - 1):+.2f} %"


def order(n0: int, n1: int, reference: int, ratio: float) -> float:
    """The alpha of (4.2): err(N) = c (N^-alpha - N_ref^-alpha), by bisection."""
    low, high = 1e-6, 40.0
    for _ in range(80):
        alpha = (low + high) / 2
        far = reference**-alpha
        low, high = (alpha, high) if (n0**-alpha - far) / (n1**-alpha - far) < ratio else (low, alpha)
    return low


def orders(n: list[int], reference: int, error: list[float]) -> list[float]:
    """EOC of every row but the first."""
    pairs = zip(n, n[1:], error, error[1:], strict=False)
    return [order(n0, n1, reference, e0 / e1) for n0, n1, e0, e1 in pairs]


def eoc_note(printed: dict) -> str:
    found = orders(printed["N"], printed["reference"], printed["error"])
    return f"By (4.2) the paper's errors give the EOC {', '.join(f'{x:.2f}' for x in found)}."


def shown(values: list[float]) -> list[str]:
    return ["", *(f"{value:.2f}" for value in values)]


def table_3_1() -> Table:
    """Points of the trapezoidal rule."""
    printed, wrong, total, gaps, head = PAPER["3.1"], 0, 0, [], ["a"]
    rows = [[f"{a:g}"] for a in printed["a"]]
    for i, eps in enumerate(printed["eps"]):
        head += [f"K̃₀ paper, ε = {eps:g}", "ours", "K₀ paper", "ours"]
        for j, a in enumerate(printed["a"]):
            for key, q in (("transformed", quadrature.power_used(a, eps)), ("plain", None)):
                theirs, ours = printed[key][i][j], quadrature.by_doubling(a, eps, q)
                wrong, total = wrong + (theirs != ours), total + 1
                if theirs <= quadrature.MOST:
                    gaps.append(theirs - quadrature.by_definition(a, eps, q))
                rows[j] += [str(k) if k <= quadrature.MOST else ">20" for k in (theirs, ours)]
    note = (
        f"{total - wrong} of {total} printed numbers are met; the least K by the definitions"
        f" (3.36), (3.37) is {min(gaps)} or {max(gaps)} smaller."
    )
    return Table("Table 3.1: 2^K points of the trapezoidal rule for eight digits", head, rows, [note])


@dataclass
class Convergence:
    """One table of errors against the finest run."""

    n: list[int]
    unknowns: list[int]
    reference: int
    reference_unknowns: int
    error: list[float]
    at: list[str]

    @property
    def eoc(self) -> list[float]:
        return orders(self.n, self.reference, self.error)


def study_of(runs: Runs, key: str, n: list[int], **more) -> Study:
    return runs.study(PAPER[key]["deck"], [*n, PAPER[key]["reference"]], **more)


def convergence(study: Study, triangles: np.ndarray, **of) -> Convergence:
    """A table of errors, with the places where they are largest."""
    found, places = study.errors(**of), []
    for _, (t, s, phi, r) in found:
        x = place(triangles[t], s, np.array(phi), np.array(r)).round(3) + 0.0
        places.append(f"Δ{t + 1} ({', '.join(f'{c:g}' for c in x)})")
    last = study.n[-1], study.unknowns[-1]
    return Convergence(study.n[:-1], study.unknowns[:-1], *last, [e for e, _ in found], places)


def reference_row(found: Convergence, printed: dict, columns: int) -> list[str]:
    row = [str(found.reference), unknowns(printed["reference_unknowns"], found.reference_unknowns)]
    return row + [""] * (columns - 2)


def unknowns(printed: int, ours: int) -> str:
    return f"{ours}" if printed == ours else f"{ours}, printed {printed}"


def table_cube(runs: Runs, key: str, n: list[int]) -> Table:
    """Tables 4.2 and 4.3."""
    printed = PAPER[key]
    found = convergence(study_of(runs, key, n), runs.triangles(printed["deck"]))
    head = ["N", "unknowns", "paper", "ours", "difference", "EOC paper", "EOC ours", "largest at"]
    rows = []
    theirs, ours = [""] + [f"{x:.2f}" for x in printed["eoc"]], shown(found.eoc)
    for i, value in enumerate(found.error):
        k = printed["N"].index(found.n[i])
        error = printed["error"][k]
        rows.append([str(found.n[i]), unknowns(printed["unknowns"][k], found.unknowns[i]), number(error)])
        rows[-1] += [number(value), percent(value, error), theirs[k], ours[i], found.at[i]]
    rows.append(reference_row(found, printed, len(head)))
    return Table(f"Table {key}: surface S1, p = {printed['p']}", head, rows, [eoc_note(printed)])


def wedge(runs: Runs, n: list[int]) -> tuple[Convergence, Convergence]:
    """S2 by (1.1), and with rho at the source, v = E + K(rho v): w = rho v solves (1.1) with emission
    rho E. The two are bands of the same runs."""
    settings = ["bands=[at_x, at_y]"]
    for i, (rho, e) in enumerate(zip(RHO_S2, EMISSION_S2, strict=True)):
        settings.append(f"scene.triangles.{i}.emission=[{e:g}, {rho * e:g}]")
    study = study_of(runs, "4.6", n, settings=settings, bands=2)
    triangles = runs.triangles(PAPER["4.6"]["deck"])
    at_y = convergence(study, triangles, band=1, weight=1 / RHO_S2)
    return convergence(study, triangles, band=0), at_y


def table_wedge(runs: Runs, n: list[int]) -> Table:
    """Table 4.6: (1.1) as it stands, and with rho at the source."""
    printed, (at_x, at_y) = PAPER["4.6"], wedge(runs, n)
    head = ["N", "unknowns", "paper", "ours, ρ(y)", "difference", "ours, ρ(x)", "difference", "EOC paper"]
    head += ["EOC ρ(y)", "EOC ρ(x)", "largest at, ρ(y)"]
    theirs, rows = [""] + [f"{x:.2f}" for x in printed["eoc"]], []
    eoc_x, eoc_y = shown(at_x.eoc), shown(at_y.eoc)
    for i, m in enumerate(n):
        k = printed["N"].index(m)
        error = printed["error"][k]
        row = [str(m), unknowns(printed["unknowns"][k], at_x.unknowns[i]), number(error)]
        row += [number(at_y.error[i]), percent(at_y.error[i], error)]
        row += [number(at_x.error[i]), percent(at_x.error[i], error), theirs[k]]
        rows.append([*row, eoc_y[i], eoc_x[i], at_y.at[i]])
    rows.append(reference_row(at_x, printed, len(head)))
    return Table("Table 4.6: surface S2, p = 1", head, rows, [eoc_note(printed)])


def table_4_5(runs: Runs) -> Table:
    """Edge exponents of S2."""
    edge, _, local = exact_and_measured(runs, "wedge_p1.yml")
    exact = {"1-2": edge[0, 2], "1-3": edge[0, 0], "2-3": edge[1, 2]}
    rows = []
    for row in PAPER["4.5"]:
        name, value = row["edge"], exact[row["edge"]]
        seen = [local[i][-3] for i, line in enumerate(LINES["wedge_p1.yml"]) if line.name == name]
        verdict = "agree" if abs(value - row["exponent"]) < 5e-4 else "the paper errs"
        rows.append([f"Δ{name[0]} and Δ{name[2]}", f"{row['degrees']}°", ", ".join(map(str, row["rho"]))])
        rows[-1] += [f"{row['exponent']:.4f}", f"{value:.4f}", f"{value - row['exponent']:+.4f}"]
        rows[-1] += [", ".join(f"{x:.3f}" for x in seen), verdict]
    head = ["edge between", "angle", "ρ", "paper", "exact", "difference", "in the solution", "verdict"]
    return Table("Table 4.5: exponents at the edges of S2", head, rows)


def table_4_6_formula(runs: Runs, n: int) -> Table:
    """(4.3) and (4.6)."""
    edge, vertex, local = exact_and_measured(runs, "cube_corner_p1.yml")
    beta = of_the_paper(runs.solution("cube_corner_p1.yml", n, 1), n)
    theirs = PAPER["(4.6)"]
    rows = [
        ["β₁, across an edge", "0.763", f"{theirs['beta_1']:.2f}", f"{beta[0]:.2f}", f"{local[1][-3]:.3f}"],
        ["β₂, towards the vertex", "", f"{theirs['beta_2']:.1f}", f"{beta[1]:.2f}", f"{local[3][-3]:.3f}"],
    ]
    rows[0].append(f"{edge[0, 0]:.6f}")
    rows[1].append(f"{vertex[0, 0]:.6f}")
    head = ["exponent", "(4.3)", "(4.6)", f"ours as (4.6), N = {n}", "in an exact solution", "exact"]
    return Table("(4.3) and (4.6): exponents of S1", head, rows)
