"""Calling other programs."""

import subprocess

from result import Problem


def output_of(*command) -> str:
    """What a program prints; if it fails, the end of its own message is the Problem."""
    words = [str(word) for word in command]
    ended = subprocess.run(words, capture_output=True, text=True, check=False)
    if ended.returncode:
        raise Problem(f"{' '.join(words)}: {ended.stderr.strip()[-400:]}")
    return ended.stdout
