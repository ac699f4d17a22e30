"""A folder of src/ includes only from those before it: data flows one way."""

import pathlib
import re
import unittest

ROOMS = ["base", "scene", "visibility", "mesh", "integrate", "system", "factors", "estimate", "output", "app"]
SRC = pathlib.Path(__file__).resolve().parents[2] / "src"


class Rooms(unittest.TestCase):
    def test_every_folder_is_a_room(self):
        self.assertEqual(sorted(p.name for p in SRC.iterdir() if p.is_dir()), sorted(ROOMS))

    def test_includes_go_up_only(self):
        seen = 0
        for path in SRC.rglob("*.[ch]"):
            room = path.parent.name
            for name in re.findall(r'#include "(\w+)/', path.read_text()):
                seen += 1
                self.assertLessEqual(ROOMS.index(name), ROOMS.index(room), f"{path}: includes {name}/")
        self.assertGreater(seen, 100)


if __name__ == "__main__":
    unittest.main()
