#!/usr/bin/env python3
"""Survey of stated errors: random scenes, polyrad's means, net powers and view factors against an oracle.

  tests/survey/run [--kinds hole,soup] [--seeds 1:20] [--tolerances 1e-2,1e-3] [--jobs 2] [--csv FILE]

Each scene (scenes.py) is run by polyrad at each tolerance. View factors come from scrambled Sobol points
and a polygon clipper, means from these and from paths (oracle.c), with --self also from polyrad at a
hundredth of the tolerance. A value is exceeded if it is farther from the oracle's than the stated error
and the oracle's own: its standard error, and what its points may have missed. What looks exceeded is
compared again with 16 times the points (4 times in rooms of many faces) and another seed. Where the
oracle's own error is above a third of the stated one it would not notice: such values are counted as too
coarse, not as held. Exit code 1 if anything is exceeded or a run failed.

Environment: POLYRAD (default build/release/polyrad), SURVEY_ORACLE (default build/release/tests/survey_oracle).
Files are kept in --keep DIR (default build/survey): oracles' answers are not computed twice.
"""

import argparse
import concurrent.futures
import csv
import hashlib
import math
import os
import resource
import statistics
import subprocess
import sys
import time
from pathlib import Path

import scenes

ROOT = Path(__file__).resolve().parents[2]
REPLICATES = 32
QUICK = ["soup", "crossed", "sheets", "needles", "hole", "slit", "lamp_near_floor", "body_black"]
# The short form runs these at the first tolerance only.
ROOMS = [("hover", 3), ("hover", 4), ("stand", 3), ("stand_uncut", 2), ("body_grey", 2), ("enclosure", 1), ("enclosure", 2)]
FIELDS = ["kind", "seed", "tolerance", "what", "row", "column", "value", "oracle", "standard_error", "stated", "assumed", "exceeded", "coarse"]


def arguments():
    p = argparse.ArgumentParser(description=__doc__.split("\n")[0], epilog="see the head of the file")
    p.add_argument("--kinds", default=",".join(scenes.KINDS), help="comma between them: " + " ".join(scenes.KINDS))
    p.add_argument("--seeds", default="1:3", help="first:last, both included, or one")
    p.add_argument("--tolerances", default="1e-2,1e-3")
    p.add_argument("--jobs", type=int, default=1)
    p.add_argument("--effort", type=int, default=0, help="oracle: 4^EFFORT times the points")
    p.add_argument("--timeout", type=float, default=300, help="processor seconds a run of polyrad may take")
    p.add_argument("--late", action="store_true", help="a run that takes longer than that is not a failure")
    p.add_argument("--short", action="store_true", help="the short form: a few scenes of each kind, half a minute")
    p.add_argument("--self", action="store_true", help="also against polyrad at a hundredth of the tolerance")
    p.add_argument("--csv", help="write all comparisons")
    p.add_argument("--runs", help="write all runs (csv): exit code, seconds, largest excess")
    p.add_argument("--keep", default=str(ROOT / "build/survey"), help="folder of decks, results, oracles' answers")
    p.add_argument("--quiet", action="store_true", help="only the report")
    return p.parse_args()


# -- oracle -----------------------------------------------------------------------------------------
def ask_oracle(keep, scene, mode, **options):
    """{(what, i, j): (value, standard error)}, from the folder if it was asked before."""
    program = os.environ.get("SURVEY_ORACLE", str(ROOT / "build/release/tests/survey_oracle"))
    text = scene.plain()
    words = [mode] + [f"{k}={v}" for k, v in sorted(options.items())]
    key = hashlib.sha256((text + " ".join(words)).encode() + Path(program).read_bytes()).hexdigest()[:16]
    answer = keep / f"{scene.kind}_{scene.seed}_{key}.oracle"
    if not answer.exists():
        plain = keep / f"{scene.kind}_{scene.seed}_{os.getpid()}.txt"
        plain.write_text(text)
        done = subprocess.run([program, str(plain)] + words, capture_output=True, text=True)
        plain.unlink()
        if done.returncode:
            raise RuntimeError(f"{program}: {done.stderr}")
        part = answer.with_suffix(f".{os.getpid()}")
        part.write_text(done.stdout)
        part.rename(answer)
    values = {}
    for line in answer.read_text().splitlines():
        what, i, j, value, error = line.split()
        values[what, int(i), int(j)] = float(value), float(error)
    return values


def oracle(keep, scene, effort, seed):
    """All that is known of a scene; the more faces, the fewer points."""
    most = 2 ** min(10, round(math.log2(4096 / len(scene.faces)))) * 4**effort
    first = int(min(32, most))
    return ask_oracle(keep, scene, "means", first=first, most=int(most), rays=first, paths=int(most), replicates=REPLICATES, seed=seed,
                      target=1e-5)


# -- polyrad ----------------------------------------------------------------------------------------
def run_polyrad(keep, scene, tolerance, limit):
    """(exit code or 'timeout', processor seconds, stderr, result file)."""
    program = os.environ.get("POLYRAD", str(ROOT / "build/release/polyrad"))
    deck = keep / f"{scene.kind}_{scene.seed}.yml"
    result = keep / f"{scene.kind}_{scene.seed}_{tolerance:g}.h5"
    deck.write_text(scene.deck())
    result.unlink(missing_ok=True)
    command = [program, "run", str(deck), "-o", str(result), "--set", f"accuracy.tolerance={tolerance:g}", "--threads", "1", "--quiet"]
    limits = lambda: resource.setrlimit(resource.RLIMIT_CPU, (math.ceil(limit), math.ceil(limit) + 5))
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    done = subprocess.run(command, capture_output=True, text=True, preexec_fn=limits, env=dict(os.environ, OMP_NUM_THREADS="1"))
    seconds = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before
    code = "timeout" if done.returncode == -24 else done.returncode
    return code, seconds, done.stderr, result


def read_result(path, scene, tolerance):
    """{(what, i, j): (value, stated error, was it assumed?)}; the error fields may not be there yet."""
    import h5py

    values = {}
    with h5py.File(path) as f:
        surfaces = f["polyrad/surfaces"]
        names = [n.decode() for n in surfaces["name"][:]]
        if names != scene.names():
            raise RuntimeError(f"surfaces are {names}")
        area = surfaces["area"][:]
        u, h = (surfaces[k][:].reshape(len(names), -1) for k in ("mean_radiosity", "mean_irradiance"))
        u_error, h_error = (surfaces[k][:].reshape(len(names), -1) if k in surfaces else None for k in ("error_radiosity", "error_irradiance"))
        bound = float(f["polyrad/diagnostics"].attrs["error_bound"])
        for b in range(u.shape[1]):
            largest = max([abs(x) for n in names for x in [scene.radiation(n)[1][b]]] + [abs(x) for x in u[:, b]])
            assumed = max(tolerance * largest, bound if math.isfinite(bound) else 0)
            for i in range(len(names)):
                values["irradiance", i, b] = h[i, b], assumed if h_error is None else h_error[i, b], h_error is None
                values["radiosity", i, b] = u[i, b], assumed if u_error is None else u_error[i, b], u_error is None
        if "net_power" in surfaces:
            power = surfaces["net_power"][:]
            error = surfaces["error_net_power"][:] if "error_net_power" in surfaces else None
            for i in range(len(names)):
                stated = assumed * area[i] if error is None else error[i]
                values["power", i, 0] = power[i], stated, error is None
            if scene.closed:
                stated = sum(values["power", i, 0][1] for i in range(len(names)))
                values["sum_of_powers", 0, 0] = float(sum(power)), stated, error is None
        if "view_factors" in f["polyrad"]:
            group = f["polyrad/view_factors"]
            matrix, error, row = group["matrix"][:], group["error"][:], group["row_sum"][:]
            for i in range(len(names)):
                for j in range(len(names)):
                    values["factor", i, j] = matrix[i, j], error[i, j], False
                values["row_sum", i, 0] = row[i], float(sum(error[i])), False
    return values, area


# -- comparison -------------------------------------------------------------------------------------
def compare(scene, tolerance, values, truth, area):
    """Rows of the table."""
    rows = []
    for (what, i, j), (value, stated, assumed) in values.items():
        if what == "sum_of_powers":
            right, error = 0.0, 0.0
        elif what == "power":
            right, error = (area[i] * x for x in truth["net", i, 0])
        else:
            right, error = truth[what, i, j]
        rows.append(dict(kind=scene.kind, seed=scene.seed, tolerance=tolerance, what=what, row=i, column=j, value=value, oracle=right,
                         standard_error=error, stated=stated, assumed=int(assumed), exceeded=0, coarse=0))
    return rows


def rounding(row):
    return 1e-12 * (abs(row["oracle"]) + 1e-3)


def excess(row, k):
    """How far beyond stated and oracle's errors; not finite counts as far."""
    if not (math.isfinite(row["value"]) and math.isfinite(row["stated"])):
        return math.inf
    return abs(row["value"] - row["oracle"]) - row["stated"] - k * row["standard_error"] - rounding(row)


def coarse(row):
    """Would an error a little above the stated one go unnoticed?"""
    return 3 * row["standard_error"] > row["stated"] + rounding(row)


def quantile(comparisons):
    """Student's t for one false alarm in a hundred surveys of so many comparisons (Hill's expansion)."""
    z, d = statistics.NormalDist().inv_cdf(1 - 0.005 / max(comparisons, 1)), REPLICATES - 1
    return z + (z**3 + z) / (4 * d) + (5 * z**5 + 16 * z**3 + 3 * z) / (96 * d**2) + (3 * z**7 + 19 * z**5 + 17 * z**3 - 15 * z) / (384 * d**3)


def itself(o, scene, tolerance, values):
    """Against polyrad at a hundredth of the tolerance: intervals that do not meet are exceeded."""
    code, _, _, path = run_polyrad(Path(o.keep), scene, tolerance / 100, o.timeout)
    if not path.exists():
        return []
    finer, _ = read_result(path, scene, tolerance / 100)
    path.unlink()
    rows = []
    for (what, i, j), (value, stated, assumed) in values.items():
        right, error, _ = finer[what, i, j]
        row = dict(kind=scene.kind, seed=scene.seed, tolerance=tolerance, what="self_" + what, row=i, column=j, value=value, oracle=right,
                   standard_error=error, stated=stated, assumed=int(assumed))
        row["exceeded"] = int(excess(row, 1) > 0)
        row["coarse"] = int(not row["exceeded"] and coarse(row))
        rows.append(row)
    return rows


def survey_scene(o, kind, seed, tolerances):
    keep = Path(o.keep)
    scene = scenes.make(kind, seed)
    rows, runs = [], []
    for tolerance in tolerances:
        code, seconds, text, path = run_polyrad(keep, scene, tolerance, o.timeout)
        run = dict(kind=kind, seed=seed, tolerance=tolerance, code=code, seconds=round(seconds, 2), faces=len(scene.faces), exceeded=0,
                   worst="", message=text.strip().splitlines()[-1][:200] if text.strip() else "")
        if path.exists():
            values, area = read_result(path, scene, tolerance)
            mine = compare(scene, tolerance, values, oracle(keep, scene, o.effort, 1), area)
            if any(excess(r, 4) > 0 for r in mine):  # a closer look, with other points
                mine = compare(scene, tolerance, values, oracle(keep, scene, o.effort + (2 if len(scene.faces) < 20 else 1), 2), area)
            k = quantile(len(mine) * o.runs_planned)
            for r in mine:
                r["exceeded"] = int(excess(r, k) > 0)
                r["coarse"] = int(not r["exceeded"] and coarse(r))
            path.unlink()
            if o.self:
                mine += itself(o, scene, tolerance, values)
            rows += mine
            bad = [r for r in mine if r["exceeded"]]
            run["exceeded"] = len(bad)
            if bad:
                w = max(bad, key=lambda r: abs(r["value"] - r["oracle"]) / max(r["stated"], 1e-300))
                run["worst"] = (f"{w['what']} {w['row']} {w['column']}: {w['value']:.6g} +- {w['stated']:.2g}, "
                                f"oracle {w['oracle']:.6g} +- {w['standard_error']:.1g}")
        runs.append(run)
    return rows, runs


def ratios(rows):
    """Stated over true error where the oracle can tell, and with the rest counted by what is certain; values that
    are right to rounding (radiosities of black faces) are left out."""
    told, least = [], []
    for r in rows:
        true, error = abs(r["value"] - r["oracle"]), r["standard_error"]
        if r["stated"] > 0 and math.isfinite(true) and max(error, true) > 1e-11 * abs(r["oracle"]):
            if true > 3 * error:
                told.append(r["stated"] / true)
            least.append(r["stated"] / (true if true > 3 * error else true + 2 * error))
    return told, least


def report(o, rows, runs):
    print(f"{len({(r['kind'], r['seed']) for r in runs})} scenes, {len(runs)} runs, {len(rows)} comparisons")
    codes = {}
    for r in runs:
        codes[r["code"]] = codes.get(r["code"], 0) + 1
    print("exit codes: " + ", ".join(f"{k}: {n}" for k, n in sorted(codes.items(), key=str)))
    print(f"{'what':18} {'tolerance':>9} {'number':>7} {'exceeded':>8} {'too coarse':>10} {'stated/true: told':>18} {'median':>8} {'90 %':>8} {'median, all':>12}")
    quantities = ["irradiance", "radiosity", "power", "sum_of_powers", "factor", "row_sum"]
    for what in quantities + ["self_" + q for q in quantities]:
        for tolerance in o.tolerance_list:
            mine = [r for r in rows if r["what"] == what and r["tolerance"] == tolerance]
            if not mine:
                continue
            told, least = ratios(mine)
            at = lambda list_, q: f"{sorted(list_)[min(int(q * len(list_)), len(list_) - 1)]:.3g}" if list_ else "-"
            mark = " (stated error assumed)" if any(r["assumed"] for r in mine) else ""
            print(f"{what:18} {tolerance:9g} {len(mine):7} {sum(r['exceeded'] for r in mine):8} {sum(r['coarse'] for r in mine):10} {len(told):18} {at(told, 0.5):>8} "
                  f"{at(told, 0.9):>8} {'>= ' + at(least, 0.5):>12}{mark}")
    seconds = sorted(r["seconds"] for r in runs)
    print(f"processor seconds a run: median {seconds[len(seconds) // 2]}, largest {seconds[-1]}")
    failed = [r for r in runs if r["exceeded"] or r["code"] not in ((0, "timeout") if o.late else (0,))]
    for r in failed:
        message = f"  {r['message']}\n" if r["message"] else ""
        print(f"FAILED {r['kind']} {r['seed']} at {r['tolerance']:g}: exit {r['code']}, exceeded {r['exceeded']}; {r['worst']}\n{message}"
              f"  again: tests/survey/run --kinds {r['kind']} --seeds {r['seed']} --tolerances {r['tolerance']:g} --csv /dev/stdout")
    late = [r for r in runs if r["code"] == "timeout"]
    if late:
        print(f"{len(late)} runs took more than {o.timeout:g} s: " + ", ".join(f"{r['kind']} {r['seed']} {r['tolerance']:g}" for r in late))
    return bool(failed)


def write_table(path, fields, rows):
    with open(path, "w", newline="") as f:
        w = csv.DictWriter(f, fields, lineterminator="\n")
        w.writeheader()
        w.writerows(rows)


def main():
    o = arguments()
    Path(o.keep).mkdir(parents=True, exist_ok=True)
    o.tolerance_list = [float(t) for t in o.tolerances.split(",")]
    first, _, last = o.seeds.partition(":")
    todo = [(k, s, o.tolerance_list) for s in range(int(first), int(last or first) + 1) for k in o.kinds.split(",")]
    if o.short:
        todo = [(k, s, o.tolerance_list[: 1 if s == 3 else 2]) for k in QUICK for s in range(1, 4)] + [(k, s, o.tolerance_list[:1]) for k, s in ROOMS]
        o.effort = -1
    o.runs_planned = sum(len(tolerances) for _, _, tolerances in todo)
    rows, runs = [], []
    with concurrent.futures.ProcessPoolExecutor(o.jobs) as pool:
        jobs = [pool.submit(survey_scene, o, *what) for what in todo]
        for job in jobs:
            more, done = job.result()
            rows += more
            runs += done
            for r in done:
                if not o.quiet:
                    print(f"{r['kind']} {r['seed']} {r['tolerance']:g}: exit {r['code']}, {r['seconds']} s, exceeded {r['exceeded']} {r['worst']}",
                          file=sys.stderr, flush=True)
    if o.csv:
        write_table(o.csv, FIELDS, rows)
    if o.runs:
        write_table(o.runs, list(runs[0]), runs)
    return int(report(o, rows, runs))


if __name__ == "__main__":
    sys.exit(main())
