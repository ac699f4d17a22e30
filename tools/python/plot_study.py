"""Error against unknowns and against time, of one or more studies (polyrad study), log-log."""

from pathlib import Path

import numpy as np

import view as space
from result import Problem, Result, names_in, parser, run, save
from study_table import table

MARKERS = "osD^vP*X"


def curves(columns: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Rows by curve: where several keys vary, one curve for all but the one with most values."""
    keys = {name: column for name, column in columns.items() if "." in name}
    text = {
        name: names_in(column) if column.dtype.kind in "OS" else [f"{value:g}" for value in column]
        for name, column in keys.items()
    }
    text = {name: column for name, column in text.items() if len(set(column)) > 1}
    along = max(text, key=lambda name: len(set(text[name])), default=None)
    rows: dict[str, list[int]] = {}
    for row in range(len(columns["error"])):
        parts = [f"{n.split('.')[-1]} {text[n][row]}" for n in text if n != along]
        rows.setdefault(", ".join(parts), []).append(row)
    return {label: np.array(row) for label, row in rows.items()}


def main() -> None:
    options = parser(__doc__, "FILE...")
    options.add_argument(
        "--labels", nargs="+", metavar="TEXT", help="one a file; default: its title"
    )
    options = options.parse_args()
    if options.labels and len(options.labels) != len(options.file):
        raise Problem(f"{len(options.file)} files, but {len(options.labels)} labels", 2)

    results = [Result(path) for path in options.file]
    figure, panels = space.plt.subplots(1, 2, figsize=(9.6, 4.4), sharey=True, layout="constrained")
    drawn = 0
    for i, result in enumerate(results):
        columns = table(result)
        name = options.labels[i] if options.labels else result.title
        for label, row in curves(columns).items():
            row = row[np.isfinite(columns["error"][row]) & (columns["error"][row] > 0)]
            if len(row) == 0:
                continue
            full = ", ".join(part for part in (name if len(results) > 1 else "", label) if part)
            style = {
                "marker": MARKERS[drawn % len(MARKERS)],
                "color": f"C{drawn % 10}",
                "ms": 5,
                "lw": 1.4,
            }
            for panel, x in zip(panels, ("unknowns", "seconds_total"), strict=True):
                if x in columns:
                    panel.loglog(columns[x][row], columns["error"][row], label=full, **style)
            drawn += 1
    if drawn == 0:
        raise Problem("no run of these studies has an error above zero")

    for panel, name in zip(panels, ("unknowns", "time of a run [s]"), strict=True):
        panel.set_xlabel(name)
        panel.grid(which="major", color="0.85", lw=0.7)
        panel.grid(which="minor", color="0.94", lw=0.4)
        panel.set_axisbelow(True)
        panel.spines[["top", "right"]].set_visible(False)
    panels[0].set_ylabel("largest error  [W/m²]")
    if panels[0].get_legend_handles_labels()[1] != [""]:
        panels[0].legend(frameon=False, fontsize=9)
    default = results[0].title if len(results) == 1 else "Convergence"
    figure.suptitle(options.title or default)
    save(figure, options.output or str(Path(options.file[0]).with_suffix(".png")), options.file[0])


run(main)
