"""A Slurm of one node on this machine, for as long as a test runs: own key, ports and folder.

Needs root, because slurmd starts jobs for others; no systemd, no cgroups, no database. Everything is
under one temporary folder, and only processes started here are ended.
"""

import os
import shutil
import socket
import subprocess
import tempfile
import time

PROGRAMS = ("munged", "mungekey", "slurmctld", "slurmd", "sbatch", "squeue", "scontrol")

# cred_expire: a requeued job waits as long as its credential could be used again, 120 s by default.
# The timeouts are those of a machine that is busy with much else.
CONFIGURATION = """\
ClusterName=polyrad
SlurmctldHost=localhost(127.0.0.1)
SlurmctldPort={controller}
SlurmdPort={node}
SlurmUser=root
SlurmdUser=root
AuthType=auth/munge
AuthInfo=socket={folder}/munge.socket,cred_expire=5
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
SwitchType=switch/none
MpiDefault=none
AccountingStorageType=accounting_storage/none
JobAcctGatherType=jobacct_gather/none
JobCompType=jobcomp/none
ReturnToService=2
InactiveLimit=0
KillWait=2
MessageTimeout=100
TCPTimeout=60
BatchStartTimeout=300
MinJobAge=300
SchedulerType=sched/backfill
SchedulerParameters=batch_sched_delay=0,sched_min_interval=0,defer_batch,bf_interval=1,sched_interval=1
NodeName={host} NodeAddr=127.0.0.1 CPUs={cpus} State=UNKNOWN
PartitionName=test Nodes={host} Default=YES MaxTime=60 State=UP
"""


def missing():
    """Why no cluster can be started here, or None."""
    if os.geteuid():
        return "Slurm's daemons must be started by root"
    absent = [name for name in PROGRAMS if not shutil.which(name, path=search_path())]
    return "not installed: " + ", ".join(absent) if absent else None


def search_path():
    return os.environ.get("PATH", "") + ":/usr/sbin:/sbin"


def free_ports(n):
    sockets = [socket.socket() for _ in range(n)]
    for s in sockets:
        s.bind(("127.0.0.1", 0))
    ports = [s.getsockname()[1] for s in sockets]
    for s in sockets:
        s.close()
    return ports


HANG = 900  # [s] longer than anything takes that does not hang


class Cluster:
    """with Cluster() as c: c.submit(...), c.wait(job)."""

    def __init__(self):
        self.daemons = []
        self.folder = tempfile.mkdtemp(prefix="polyrad_slurm_")

    def __enter__(self):
        try:
            self.start()
        except BaseException:
            self.__exit__()
            raise
        return self

    def __exit__(self, *_):
        for daemon in reversed(self.daemons):
            daemon.terminate()
        for daemon in reversed(self.daemons):
            try:
                daemon.wait(60)
            except subprocess.TimeoutExpired:
                daemon.kill()
                daemon.wait()
        shutil.rmtree(self.folder, ignore_errors=True)

    def path(self, name):
        return os.path.join(self.folder, name)

    def daemon(self, name, *options):
        log = open(self.path(name + ".out"), "wb")
        program = shutil.which(name, path=search_path())
        with log:
            self.daemons.append(subprocess.Popen([program, *options], stdout=log, stderr=log,
                                                 env=self.environment, start_new_session=True))

    def start(self):
        os.chmod(self.folder, 0o755)
        for name in ("state", "spool"):
            os.mkdir(self.path(name))
        self.environment = dict(os.environ, SLURM_CONF=self.path("slurm.conf"), PATH=search_path())
        controller, node = free_ports(2)
        with open(self.path("slurm.conf"), "w") as f:
            f.write(CONFIGURATION.format(folder=self.folder, host=socket.gethostname().split(".")[0],
                                         cpus=os.cpu_count(), controller=controller, node=node))
        subprocess.run(["mungekey", "--create", "--keyfile=" + self.path("munge.key")], check=True,
                       env=self.environment)
        self.daemon("munged", "--foreground", "--force", "--key-file=" + self.path("munge.key"),
                    "--socket=" + self.path("munge.socket"), "--pid-file=" + self.path("munge.pid"),
                    "--log-file=" + self.path("munge.log"), "--seed-file=" + self.path("munge.seed"))
        self.until(lambda: os.path.exists(self.path("munge.socket")), "munged")
        self.daemon("slurmctld", "-D", "-f", self.path("slurm.conf"))
        self.daemon("slurmd", "-D", "-f", self.path("slurm.conf"))
        self.until(lambda: "idle" in self.call("sinfo", "-h", "-o", "%t", check=False), "the node")

    def until(self, condition, what):
        end = time.monotonic() + HANG
        while not condition():
            dead = [d.args[0] for d in self.daemons if d.poll() is not None]
            if dead or time.monotonic() > end:
                raise RuntimeError("%s did not come up%s\n%s" % (
                    what, "; ended: " + ", ".join(dead) if dead else "", self.logs()))
            time.sleep(0.05)

    def logs(self):
        text = ""
        for name in sorted(os.listdir(self.folder)):
            if name.endswith((".log", ".out")):
                with open(self.path(name), errors="replace") as f:
                    text += "--- %s\n%s" % (name, "".join(f.readlines()[-30:]))
        return text

    def call(self, *words, check=True, **more):
        p = subprocess.run(words, env=self.environment, text=True, stdout=subprocess.PIPE,
                           stderr=subprocess.STDOUT, timeout=HANG, **more)
        if check and p.returncode:
            raise RuntimeError("%s: %s\n%s" % (" ".join(words), p.stdout, self.logs()))
        return p.stdout

    def submit(self, *words, **more):
        """sbatch; the job's number."""
        return self.call("sbatch", "--parsable", *words, **more).strip()

    def state(self, job):
        """{task or job: state} of a job, also of one that has ended."""
        text = self.call("squeue", "-h", "-t", "all", "-j", job, "-o", "%i %T", "-r")
        return dict(line.split() for line in text.splitlines())

    def wait(self, job):
        """Until nothing of the job is left to do; the states."""
        over = {"COMPLETED", "FAILED", "CANCELLED", "TIMEOUT", "NODE_FAIL", "OUT_OF_MEMORY", "DEADLINE"}
        end = time.monotonic() + HANG
        while True:
            states = self.state(job)
            if states and set(states.values()) <= over:
                return states
            if time.monotonic() > end:
                raise RuntimeError("job %s is still %s\n%s" % (job, states, self.logs()))
            time.sleep(0.2)


if __name__ == "__main__":
    print(missing() or "")
