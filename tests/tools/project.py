"""Calling the project's tools from tests."""

import subprocess
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def call(tool: str, *arguments, folder=None) -> subprocess.CompletedProcess:
    """Run tools/TOOL ARGUMENTS..., with what it prints as text."""
    command = [str(ROOT / "tools" / tool), *map(str, arguments)]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=900)
