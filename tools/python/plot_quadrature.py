"""Relative error against kernel values of quadrature rules: tests/bench/bench_quadrature."""

import csv
from pathlib import Path

import view as space
from result import Problem, parser, run, save

SHOWN = ("0.1", "0.001", "1e-06", "1e-12")


def read(path: str) -> dict[tuple[str, str], list[tuple[float, float]]]:
    """Curves by distance and rule."""
    curves: dict[tuple[str, str], list[tuple[float, float]]] = {}
    try:
        with open(path, newline="", encoding="utf-8") as file:
            for row in csv.DictReader(file):
                point = (float(row["kernel_values"]), float(row["relative_error"]))
                curves.setdefault((row["distance"], row["rule"]), []).append(point)
    except OSError as error:
        raise Problem(f"{path} cannot be read: {error.strerror}") from None
    except (KeyError, TypeError, ValueError, UnicodeDecodeError):
        raise Problem(f"{path} is not a table of tests/bench/bench_quadrature") from None
    return curves


def main() -> None:
    options = parser(__doc__, "TABLE").parse_args()
    curves = read(options.file)
    shown = [d for d in SHOWN if any(key[0] == d for key in curves)]
    if not shown:
        raise Problem(f"{options.file} has none of the distances {', '.join(SHOWN)}")
    figure, panels = space.plt.subplots(
        1, len(shown), figsize=(3.2 * len(shown), 3.8), sharey=True, layout="constrained", squeeze=False
    )
    rules = list(dict.fromkeys(rule for _, rule in curves))
    for panel, distance in zip(panels[0], shown, strict=True):
        for i, rule in enumerate(rules):
            points = sorted(curves.get((distance, rule), []))
            x = [n for n, _ in points]
            y = [max(error, 1e-16) for _, error in points]
            panel.loglog(x, y, label=rule, color=f"C{i}", marker="osD^v"[i % 5], ms=3, lw=1.2)
        panel.set_title(f"distance {float(distance):g}")
        panel.set_xlabel("kernel values")
        panel.set_ylim(5e-17, 10)
        panel.grid(color="0.88", lw=0.6)
        panel.spines[["top", "right"]].set_visible(False)
    panels[0][0].set_ylabel("relative error")
    panels[0][0].legend(frameon=False, fontsize=8)
    figure.suptitle(options.title or "One nearly singular integral by five rules")
    save(figure, options.output or str(Path(options.file).with_suffix(".png")), options.file)


run(main)
