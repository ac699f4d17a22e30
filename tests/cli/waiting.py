"""Waiting for what a process does. No test waits for a time: what takes a tenth of a second on an idle
machine takes ten on a busy one, and the start of the program alone may."""

import os
import re
import resource
import time

HANG = 900  # [s] longer than anything takes that does not hang, on a machine that is busy with much else


def until(p, condition):
    """Until it holds: True, or the process has ended: whether it holds then."""
    end = time.monotonic() + HANG
    while not condition():
        if p.poll() is not None:
            return bool(condition())
        if time.monotonic() > end:
            p.kill()
            raise AssertionError("%s hangs" % (p.args,))
        time.sleep(0.0005)
    return True


def catches(p, number):
    """True once the process has a handler of this signal."""
    try:
        with open("/proc/%d/status" % p.pid, encoding="ascii", errors="replace") as f:
            found = re.search(r"^SigCgt:\s*([0-9a-f]+)$", f.read(), re.M)
    except OSError:  # it has ended
        return False
    return bool(found and int(found[1], 16) >> (number - 1) & 1)


def processor_seconds(p):
    """What the process has used so far, of all threads: Linux makes its clock from its number."""
    try:
        return time.clock_gettime(~p.pid << 3 | 2)
    except OSError:  # it has ended
        return 0.0


def until_ready(p, number, moment=0.0):
    """Until the signal does not find the process unprepared, and it has worked for `moment` [s of processor
    time]: the work that is done by then does not depend on what else the machine does."""
    return until(p, lambda: catches(p, number)) and until(p, lambda: processor_seconds(p) >= moment)


def has_opened(p, path):
    """True once the process has the file open."""
    try:
        folder = "/proc/%d/fd" % p.pid
        return any(os.path.samefile(os.path.join(folder, fd), path) for fd in os.listdir(folder))
    except OSError:  # it has ended, or closed one in between
        return False


def used_by_children():
    """Processor time of the processes that were waited for."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def is_larger(path, size):
    """True for a file that has grown beyond size."""
    try:
        return os.path.getsize(path) > size
    except OSError:
        return False
