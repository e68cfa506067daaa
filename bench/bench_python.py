# SPDX-License-Identifier: Apache-2.0
"""What a mapped frame costs from Python beside the command: the same sequence, in turns, nothing from the cache.

PYTHONPATH=build/python /usr/bin/python3 -P bench/bench_python.py build/bin/estancia SEQUENCE [REPETITIONS]
"""

from __future__ import annotations

import os
import pathlib
import statistics
import subprocess
import sys
import tempfile

PROGRAM = """
import estancia, sys
estancia.map_sequence(sys.argv[1], sys.argv[2], estancia.load_model(), cache=False)
"""


def seconds(words: list[str]) -> float:
    """Processor time, which other work on the machine changes least."""
    before = os.times()
    subprocess.run(words, check=True, capture_output=True)
    after = os.times()
    return after.children_user + after.children_system - before.children_user - before.children_system


def main() -> None:
    command, sequence = sys.argv[1:3]
    repetitions = int(sys.argv[3]) if len(sys.argv) > 3 else 5
    ratios = []
    for i in range(repetitions):
        with tempfile.TemporaryDirectory() as folder:
            ours = [sys.executable, "-P", "-c", PROGRAM, sequence, str(pathlib.Path(folder) / "python.estancia")]
            theirs = [command, "map", sequence, "--no-cache", "-o", str(pathlib.Path(folder) / "command.estancia")]
            times = [seconds(ours), seconds(theirs)] if i % 2 else [seconds(theirs), seconds(ours)][::-1]
        ratios.append(times[0] / times[1])
        print(f"Python {times[0]:.2f} s, command {times[1]:.2f} s of processor time: {ratios[-1]:.3f}")
    print(f"median ratio {statistics.median(ratios):.3f}")


if __name__ == "__main__":
    main()
