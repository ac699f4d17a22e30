"""Progress on a terminal, and its absence elsewhere."""

import os
import pty
import re
import subprocess
import unittest

from test_cli import CORNER, PROGRAM, Case
from waiting import HANG

# Enough work for some seconds of one core, with 3 elements.
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
        out = p.communicate(timeout=HANG)[0].decode()
        os.close(master)
        self.assertEqual(p.returncode, 0, text)
        return text.decode(), out

    def test_line_on_a_terminal(self):
        for elements in (3, 6, 12):  # until its matrix, be it compressed, takes long enough for a line after half a second
            text, out = self.on_terminal(*LONG, "--set", "method.elements=%d" % elements)
            if float(re.search(r"assemble (\S+),", out)[1]) > 1.5:
                break
        else:
            self.skipTest("this machine is too fast for a line after half a second")
        self.assertIn("\r", text)
        self.assertNotIn("\n", text)
        lines = [line for line in text.replace("\x1b[K", "").split("\r") if line]
        for line in lines:
            self.assertRegex(line, r"^(scene|visibility|mesh|matrix|solve|estimate|means|picture|writing)")
            self.assertLess(len(line), 80)
        self.assertTrue(any(re.match(r"matrix: \d+k? of \d+k? (blocks|bases|(far|near) clusters) \(\d+ %\), \S+/s, .* left; "
                                     r".*, [\d.]+ GB$", line)
                            for line in lines), lines)
        self.assertTrue(text.endswith("\r\x1b[K"), "the line is cleared")
        self.assertIn("written", out)

    def test_quiet_terminal(self):
        self.assertEqual(self.on_terminal(*LONG, "--quiet"), ("", ""))

    def test_log_has_a_line_a_minute(self):
        """None before the first minute is over."""
        p = subprocess.run([PROGRAM, *LONG], cwd=self.folder, text=True, stdout=subprocess.PIPE,
                           stderr=subprocess.PIPE, timeout=HANG)
        self.assertEqual(p.returncode, 0, p.stderr)
        lines = p.stderr.splitlines()
        self.assertLessEqual(len(lines), float(re.search(r"  time +(\S+) s:", p.stdout)[1]) / 60)
        for line in lines:
            self.assertRegex(line, r"^progress: .* GB$")


if __name__ == "__main__":
    unittest.main()
