"""The columns of a study file (polyrad study)."""

import h5py
import numpy as np

from result import Problem, Result


def table(result: Result) -> dict[str, np.ndarray]:
    """The columns of a study, by name."""
    group = result.file.get("polyrad/study") or result.file.get("study")
    if not isinstance(group, h5py.Group):
        raise Problem(f"{result.path} holds no study; was it written by polyrad study?")
    columns = {name: group[name][()] for name in group if group[name].ndim == 1}
    for name in ("unknowns", "error"):
        if name not in columns:
            raise Problem(f"the study in {result.path} has no column '{name}'")
    return columns
