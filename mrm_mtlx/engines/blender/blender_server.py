"""Answers requests in Blender's Python module: a program of its own, run by an interpreter that has `bpy`.

Not part of the import package: `process` starts it as a separate process, and nothing imports it. It needs NumPy and
bpy alone. What it can do is in another file, which it is given: a table OPERATIONS of functions by name. Requests come
on stdin, answers go to what was stdout; Blender's own chatter goes to the log file that is named on the command line.

A message is eight bytes of length, big-endian, and an .npz archive: member "json" holds the plain data, the others are
arrays.
"""

import ctypes
import io
import json
import os
import runpy
import shutil
import signal
import struct
import sys
from pathlib import Path

import bpy
import numpy as np


def main(operations_path, log_path):
    """Answer requests until stdin ends."""
    answers = os.fdopen(os.dup(1), "wb")
    log = os.open(log_path, os.O_WRONLY | os.O_CREAT | os.O_APPEND, 0o600)
    os.dup2(log, 1)
    os.dup2(log, 2)
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # an interrupt is for the process that started this one
    bpy.utils.expose_bundled_modules()  # oslquery, without which script nodes have no sockets; pxr
    operations = runpy.run_path(operations_path)["OPERATIONS"]
    try:
        answer_requests(operations, answers, log, log_path)
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), answers.fileno())  # or closing it would complain
    finally:
        # Whoever started this has ended, perhaps without the time to tidy up.
        shutil.rmtree(Path(log_path).parent, ignore_errors=True)


def answer_requests(operations, answers, log, log_path):
    """Answer requests until there are no more, or nobody to answer."""
    while True:
        request = receive(sys.stdin.buffer)
        if request is None:
            return
        plain, arrays = request
        start = os.fstat(log).st_size
        try:
            answer = operations[plain.pop("operation")](**plain, **({"arrays": arrays} if arrays else {}))
        except Exception as error:
            answer = {"error": f"{type(error).__name__}: {error}"}
        ctypes.CDLL(None).fflush(None)  # Blender prints through C's buffers
        answer["log"] = Path(log_path).read_bytes()[start:].decode("utf-8", "replace")
        send(answers, answer)


def receive(stream):
    """Plain data and arrays of the next message, or None at the end of the stream."""
    head = stream.read(8)
    if len(head) < 8:
        return None
    with np.load(io.BytesIO(stream.read(struct.unpack(">Q", head)[0])), allow_pickle=False) as archive:
        arrays = {name: archive[name] for name in archive.files}
    return json.loads(str(arrays.pop("json"))), arrays


def send(stream, plain):
    """Write a message of plain data."""
    buffer = io.BytesIO()
    np.savez(buffer, json=np.array(json.dumps(plain)))
    stream.write(struct.pack(">Q", buffer.tell()) + buffer.getvalue())
    stream.flush()


if __name__ == "__main__":
    main(*sys.argv[1:])
