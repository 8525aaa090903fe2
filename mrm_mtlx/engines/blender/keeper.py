"""Runs a program of Blender and waits: a program of its own, of the standard library alone.

While Blender works, is stopped, or hangs, it does not notice that whoever started it has ended. This process does: it
ends Blender then, and removes the folder that the two shared. Started by `process`, imported by nothing.
"""

import contextlib
import os
import shutil
import signal
import subprocess
import sys

# Seconds between two looks at who started it.
LOOK_S = 0.2


def main(user, folder, *command):
    """Run the command until it ends or its user does; its exit status."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # an interrupt is for the process that started this one
    with subprocess.Popen(command) as server:
        for stream in (0, 1):  # the server's alone
            os.close(stream)
        while True:
            with contextlib.suppress(subprocess.TimeoutExpired):
                return server.wait(LOOK_S)
            if os.getppid() != int(user):
                server.kill()
                server.wait()
                shutil.rmtree(folder, ignore_errors=True)
                return 1


def end_as(status):
    """End this process as another has ended: of a signal, or with an exit status."""
    if status < 0:
        signal.signal(-status, signal.SIG_DFL)
        os.kill(os.getpid(), -status)
    os._exit(status)  # the streams are closed


if __name__ == "__main__":
    end_as(main(*sys.argv[1:]))
