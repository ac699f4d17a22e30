"""tools/testlog: the closing line and the exit code."""

import json
import tempfile
import unittest
from pathlib import Path

from project import call


class Testlog(unittest.TestCase):
    def told(self, *results: str, broken: str = ""):
        tests = [
            {"name": f"test {i}", "result": r, "duration": 0.5, "stdout": f"said {i}\n"}
            for i, r in enumerate(results)
        ]
        with tempfile.TemporaryDirectory() as folder:
            log = Path(folder) / "testlog.json"
            log.write_text("".join(json.dumps(test) + "\n" for test in tests) + broken)
            return call("testlog", log)

    def expect(self, told, last: str, code: int):
        self.assertEqual(told.stdout.splitlines()[-1], last)
        self.assertEqual(told.returncode, code)
        counts = [line for line in told.stdout.splitlines() if " passed, " in line]
        self.assertEqual(counts, [last])

    def test_all_passed(self):
        told = self.told("OK", "OK", "EXPECTEDFAIL")
        self.expect(told, "3 passed, 0 failed", 0)
        self.assertNotIn("said", told.stdout)

    def test_failures_are_shown(self):
        told = self.told("OK", "FAIL", "TIMEOUT", "ERROR", "UNEXPECTEDPASS", "INTERRUPT")
        self.expect(told, "1 passed, 5 failed", 1)
        self.assertIn("test 1: FAIL", told.stdout)
        self.assertIn("said 1", told.stdout)
        self.assertNotIn("said 0", told.stdout)

    def test_skipped_ones_are_counted(self):
        self.expect(self.told("OK", "SKIP", "SKIP"), "1 passed, 0 failed, 2 skipped", 0)

    def test_nothing_but_skips_is_no_success(self):
        self.expect(self.told("SKIP"), "0 passed, 0 failed, 1 skipped", 1)

    def test_no_test_is_no_success(self):
        self.expect(self.told(), "0 passed, 0 failed", 1)

    def test_no_log_is_no_success(self):
        self.expect(call("testlog", "/nowhere/testlog.json"), "0 passed, 0 failed", 1)

    def test_an_unfinished_line_is_a_failure(self):
        self.expect(self.told("OK", broken='{"name": "tes'), "1 passed, 1 failed", 1)

    def test_long_output_is_cut(self):
        line = json.dumps(
            {"name": "long", "result": "FAIL", "stdout": "\n".join(map(str, range(1000)))}
        )
        told = self.told(broken=line)
        self.assertIn("960 lines of stdout before", told.stdout)
        self.assertLess(len(told.stdout.splitlines()), 60)
