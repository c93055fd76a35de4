"""A process that runs cases: names come in line by line, outcomes go out as lines of JSON.

Each case may take `SECONDS` of the processor and `MEMORY` more than the process has at its start. One that takes more
time ends the process (SIGXCPU), after the stack was written to stderr; the pool starts another.
"""

from __future__ import annotations

import dataclasses
import faulthandler
import json
import os
import resource
import signal
import sys
import time

from .judge import judge

# Lines beside given normals are a fit of up to 200 solves, which on the finest plans takes longest.
SECONDS = 120
MEMORY = 2 * 1024**3


def limit_memory() -> None:
    with open("/proc/self/statm") as file:
        now = int(file.read().split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (now + MEMORY, resource.RLIM_INFINITY))


def limit_time() -> None:
    used = time.process_time()
    resource.setrlimit(resource.RLIMIT_CPU, (int(used) + SECONDS + 1, resource.RLIM_INFINITY))


def main() -> None:
    answers = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)  # whatever a case prints is no answer
    faulthandler.enable()
    faulthandler.register(signal.SIGXCPU, chain=True)
    limit_memory()
    for line in sys.stdin:
        limit_time()
        start = time.process_time()
        outcome = dataclasses.replace(judge(line.strip()), seconds=round(time.process_time() - start, 3))
        print(json.dumps(dataclasses.asdict(outcome)), file=answers, flush=True)


if __name__ == "__main__":
    main()
