"""The container recipe, as far as it can be tested without a container engine: its instructions, its
packages against tools/setup, apt-get and the program's own libraries. POLYRAD_TEST_FULL=1, with buildah
and debootstrap, as root: the image is built from a Debian that is fetched here, and runs a deck."""

import os
import pathlib
import re
import shutil
import subprocess
import tempfile
import unittest

SOURCE, PROGRAM = pathlib.Path(os.environ["POLYRAD_SOURCE"]), os.environ["POLYRAD"]
KNOWN = {"FROM", "RUN", "COPY", "WORKDIR", "ENTRYPOINT"}


def instructions():
    text = re.sub(r"^#.*\n", "", (SOURCE / "Containerfile").read_text(), flags=re.MULTILINE)
    lines = re.sub(r"\\\n", " ", text).splitlines()
    return [line.split(None, 1) for line in lines if line.strip()]


def packages():
    """Of each stage."""
    runs = [rest for name, rest in instructions() if name == "RUN" and "apt-get install" in rest]
    return [re.search(r"--no-install-recommends ([^&]*)", r)[1].split() for r in runs]


def simulate(names):
    return subprocess.run(["apt-get", "install", "--simulate", "-qq", "--no-install-recommends", *names],
                          capture_output=True, text=True, timeout=900)


class Container(unittest.TestCase):
    def test_instructions(self):
        found = instructions()
        self.assertTrue({name for name, _ in found} <= KNOWN)
        self.assertEqual([n for n, _ in found].count("FROM"), 2)
        for name, rest in found:
            if name == "RUN":
                subprocess.run(["bash", "-n", "-c", rest], check=True)
            if name == "COPY" and "--from" not in rest:
                self.assertTrue((SOURCE / rest.split()[0]).exists())

    def test_packages_to_build_are_those_of_setup(self):
        setup = (SOURCE / "tools/setup").read_text()
        wanted = set(re.search(r"missing=\(\)\n(.*?)if \[", setup, re.DOTALL)[1].split("missing+=(")[1:])
        wanted = {p for part in wanted for p in part.split(")")[0].split()}
        # h5diff and Check are for tests; git tells the version
        self.assertEqual(set(packages()[0]), wanted - {"hdf5-tools", "check"} | {"git"})

    @unittest.skipUnless(shutil.which("apt-get") and simulate(["libc6"]).returncode == 0,
                         "no apt-get with lists of packages here")
    def test_packages_exist(self):
        if "bookworm" not in pathlib.Path("/etc/os-release").read_text():
            self.skipTest("names of packages are those of Debian 12, and this is another system")
        for names in packages():
            made = simulate(names)
            self.assertEqual(made.returncode, 0, made.stderr)

    @unittest.skipUnless(shutil.which("dpkg") and shutil.which("ldd"), "no dpkg here")
    def test_packages_to_run_are_what_the_program_needs(self):
        if "bookworm" not in pathlib.Path("/etc/os-release").read_text():
            self.skipTest("names of packages are those of Debian 12, and this is another system")
        needed = subprocess.run(["readelf", "-d", PROGRAM], capture_output=True, text=True).stdout
        needed = re.findall(r"NEEDED.*\[(.*?)\]", needed)
        self.assertTrue(needed)
        paths = dict(re.findall(r"(\S+) => (\S+)", subprocess.run(["ldd", PROGRAM], capture_output=True, text=True).stdout))
        for name in needed:
            if name.startswith(("libm.", "libc.", "ld-linux", "libpolyrad")):
                continue
            real = os.path.realpath(paths[name])
            owner = subprocess.run(["dpkg", "-S", real], capture_output=True, text=True).stdout.split(":")[0]
            # OpenBLAS stands behind the names libblas and libopenblas by Debian's alternatives
            self.assertTrue(owner in packages()[1] or "openblas" in owner, f"{name} is of {owner or real}")

    @unittest.skipUnless(os.environ.get("POLYRAD_TEST_FULL"), "POLYRAD_TEST_FULL=1 builds the image")
    @unittest.skipUnless(shutil.which("buildah") and shutil.which("debootstrap") and os.geteuid() == 0,
                         "no buildah and debootstrap, or not root")
    def test_built(self):
        with tempfile.TemporaryDirectory() as folder:
            storage = {**os.environ, "BUILDAH_ISOLATION": "chroot", "STORAGE_DRIVER": "vfs"}

            def buildah(*words):
                made = subprocess.run(["buildah", "--root", f"{folder}/storage", "--runroot", f"{folder}/run", *words],
                                      env=storage, capture_output=True, text=True)
                self.assertEqual(made.returncode, 0, made.stdout + made.stderr)
                return made.stdout.strip()

            debian, source, work = f"{folder}/debian", f"{folder}/source", f"{folder}/work"
            subprocess.run(["debootstrap", "--variant=minbase", "bookworm", debian], check=True, capture_output=True)
            subprocess.run(["git", "clone", "--quiet", SOURCE, source], check=True)
            shutil.copytree(SOURCE / "inputs", f"{work}/inputs")
            base = buildah("from", "scratch")
            buildah("add", base, debian, "/")
            buildah("commit", base, "docker.io/library/debian:12")
            buildah("build", "--pull-never", "--tag", "polyrad", source)
            image = buildah("from", "--pull-never", "polyrad")
            said = buildah("run", image, "--", "polyrad", "--version")
            commit = subprocess.run(["git", "-C", source, "describe", "--always"], check=True,
                                    capture_output=True, text=True).stdout.strip()
            self.assertIn(f"({commit})", said)
            said = buildah("run", "--volume", f"{work}:/work", image, "--", "polyrad", "run",
                           "inputs/cube_corner.yml", "-o", "cube_corner.vtkhdf")
            self.assertIn("written  cube_corner.vtkhdf", said)
            self.assertTrue(os.path.getsize(f"{work}/cube_corner.vtkhdf") > 10000)


if __name__ == "__main__":
    unittest.main()
