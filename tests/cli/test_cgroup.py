"""A limit of the batch system or the container, a cgroup: runs are refused at once with both numbers, or
take the compressed form; the kernel never kills one. Needs the right to make a cgroup."""

import os
import re
import unittest
from contextlib import contextmanager

import test_cli
from test_cli import CORNER

MEGA = 1000 * 1000
HERE = "/sys/fs/cgroup"


def own(controller):
    """This process's place in a hierarchy of version 1, or in that of version 2 (controller "")."""
    with open("/proc/self/cgroup", encoding="utf-8") as file:
        for line in file:
            _, names, path = line.rstrip("\n").split(":", 2)
            if controller in names.split(","):
                return path.lstrip("/")
    return None


def candidates():
    """Folders in which a group may be made, and the name of the limit there."""
    if own("memory") is not None:
        for path in (own("memory"), ""):
            yield os.path.join(HERE, "memory", path), "memory.limit_in_bytes"
    if own("") is not None:
        for path in (own(""), ""):
            yield os.path.join(HERE, path), "memory.max"


@contextmanager
def group(limit):
    """The path of a cgroup with this limit; None: not allowed here."""
    for folder, name in candidates():
        path = os.path.join(folder, "polyrad_test_%d" % os.getpid())
        try:
            os.mkdir(path)
        except OSError:
            continue
        try:
            with open(os.path.join(path, name), "w", encoding="utf-8") as file:
                file.write(str(limit))
        except OSError:
            os.rmdir(path)
            continue
        try:
            yield path
        finally:
            os.rmdir(path)
        return
    yield None


class Cgroup(test_cli.Case):
    def within(self, limit, *words):
        """Run under the limit."""
        with group(limit) as path:
            if path is None:
                self.skipTest("no cgroup with a limit of memory can be made here")

            def enter():
                with open(os.path.join(path, "cgroup.procs"), "w", encoding="utf-8") as file:
                    file.write(str(os.getpid()))

            return self.call(*words, preexec_fn=enter)

    def test_refused_with_both_numbers(self):
        p = self.within(1000 * MEGA, "run", CORNER, "--set", "method.elements=32", "--set", "method.matrix=dense")
        self.assertEqual(p.returncode, 3, p.stderr)
        need, have = map(float, re.search(r"needs (\S+) GB of memory.* (\S+) GB are available", p.stderr).groups())
        self.assertTrue(40 < need < 110 and 0.1 < have < 1.0, p.stderr)
        self.assertEqual(self.files(), [])

    def test_compressed_where_only_that_fits(self):
        """18 432 unknowns: 2.7 GB dense."""
        p = self.within(700 * MEGA, "run", CORNER, "--set", "method.elements=16", "--set",
                        "method.quadrature_tolerance=1e-6")
        self.assertEqual((p.returncode, p.stderr), (0, ""))
        self.assertIn("matrix   hierarchical", p.stdout)
        self.assertEqual(self.files(), ["cube_corner.vtkhdf"])

    def test_never_killed(self):
        """From far below the need to far above it: refused, or done."""
        codes = []
        for limit in range(60, 310, 50):
            p = self.within(limit * MEGA, "run", CORNER, "--set", "method.elements=16", "--set",
                            "method.quadrature_tolerance=1e-6", "-o", "out.h5")
            self.assertIn(p.returncode, (0, 3), "%d MB: %s" % (limit, p.stderr))
            self.assertEqual(self.files(), [] if p.returncode else ["out.h5"])
            codes.append(p.returncode)
            if not p.returncode:
                os.remove(self.path("out.h5"))
            else:
                self.assertRegex(p.stderr, r"needs \S+ GB of memory.* \S+ GB are available")
        self.assertEqual(codes, sorted(codes, reverse=True))
        self.assertEqual((codes[0], codes[-1]), (3, 0))


if __name__ == "__main__":
    unittest.main()
