"""Progress on a terminal, and its absence elsewhere."""

import os
import pty
import re
import subprocess
import unittest

from test_cli import CORNER, PROGRAM, Case

# Enough work for some seconds of one core; what is checked does not depend on its speed.
LONG = ("run", CORNER, "-o", "x.vtkhdf", "--set", "method={mesh: graded, elements: 3, degree: 5, grading: 2}")


class Progress(Case):
    def on_terminal(self, *words):
        """What the program writes to a terminal as stderr; stdout is a pipe."""
        master, slave = pty.openpty()
        p = subprocess.Popen([PROGRAM, *words], cwd=self.folder, stdout=subprocess.PIPE, stderr=slave)
        os.close(slave)
        text = b""
        while True:
            try:
                part = os.read(master, 65536)
            except OSError:  # Linux: the other end is closed
                break
            if not part:
                break
            text += part
        out = p.communicate(timeout=60)[0].decode()
        os.close(master)
        self.assertEqual(p.returncode, 0, text)
        return text.decode(), out

    def test_line_on_a_terminal(self):
        text, out = self.on_terminal(*LONG)
        if float(re.search(r"  time +(\S+) s:", out)[1]) < 1.5:
            self.skipTest("this machine is too fast for a line after half a second")
        self.assertIn("\r", text)
        self.assertNotIn("\n", text)
        lines = [line for line in text.replace("\x1b[K", "").split("\r") if line]
        for line in lines:
            self.assertRegex(line, r"^(scene|visibility|mesh|matrix|solve|estimate|means and picture|writing)")
            self.assertLess(len(line), 80)
        self.assertTrue(any(re.match(r"matrix: \d+k? of \d+k? blocks \(\d+ %\), \S+/s, .* left; .*, [\d.]+ GB$", line)
                            for line in lines), lines)
        self.assertTrue(text.endswith("\r\x1b[K"), "the line is cleared")
        self.assertIn("written", out)

    def test_quiet_terminal(self):
        self.assertEqual(self.on_terminal(*LONG, "--quiet"), ("", ""))

    def test_short_log_has_none(self):
        self.done(*LONG)  # no word on stderr within the first minute


if __name__ == "__main__":
    unittest.main()
