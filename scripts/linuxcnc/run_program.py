#!/usr/bin/python3
"""The user interface of a LinuxCNC controller without a screen: homes, runs the program in $NGC, and checks where the
tip was. While the control holds the tip it has to be on the lines of the program, and has to reach the end of each
cut. Writes "passed …" or "FAILED …" to $RESULT."""
import os
import re
import time

import linuxcnc

TOLERANCE = 0.05  # mm: blending (G64) and the time between two samples
LIMIT_S = 180.0


def run():
    command, status, errors = linuxcnc.command(), linuxcnc.stat(), linuxcnc.error_channel()
    time.sleep(1)
    command.state(linuxcnc.STATE_ESTOP_RESET)
    command.wait_complete()
    command.state(linuxcnc.STATE_ON)
    command.wait_complete()
    command.mode(linuxcnc.MODE_MANUAL)
    command.wait_complete()
    command.home(-1)
    began = time.time()
    while time.time() - began < 10:
        status.poll()
        if all(status.homed[:5]):
            break
        time.sleep(0.1)
    command.mode(linuxcnc.MODE_AUTO)
    command.wait_complete()
    command.program_open(os.environ["NGC"])
    command.auto(linuxcnc.AUTO_RUN, 0)
    began, samples = time.time(), []
    while time.time() - began < LIMIT_S:
        status.poll()
        samples.append((status.motion_line, status.position[:3]))
        if status.interp_state == linuxcnc.INTERP_IDLE and time.time() - began > 1:
            break
        time.sleep(0.01)
    message = errors.poll()
    if message:
        return None, "the controller says: %s" % message[1]
    return samples, "%.0f s" % (time.time() - began)


def distance(p, a, b):
    way = [b[i] - a[i] for i in range(3)]
    square = sum(w * w for w in way)
    along = sum((p[i] - a[i]) * way[i] for i in range(3)) / square if square else 0.0
    along = min(1.0, max(0.0, along))
    return sum((p[i] - a[i] - way[i] * along) ** 2 for i in range(3)) ** 0.5


def lines_of(path):
    """Segments while the tip is held, by line, and the ends of cuts."""
    segments, cuts, at, held, before, rate, fastest = {}, [], [None] * 3, False, None, 0.0, 0.0
    with open(path) as file:
        for number, line in enumerate(file, 1):
            held = (held or "M428" in line) and "M429" not in line
            if line.startswith("("):
                continue
            for i, name in enumerate("XYZ"):
                word = re.search(r"\b%s(-?[\d.]+)" % name, line)
                at[i] = float(word.group(1)) if word else at[i]
            word = re.search(r"F([\d.]+)", line)
            rate = float(word.group(1)) if word else rate
            fastest = max(fastest, rate)
            if held and None not in at and re.match(r"N\d+ (G1 )?[XYZAC]", line):
                here = tuple(at)
                if before is not None:
                    segments[number] = (before, here)
                    if rate < fastest:
                        cuts.append(here)
                before = here
    return segments, cuts


def judged():
    samples, told = run()
    if samples is None:
        return "FAILED " + told
    segments, cuts = lines_of(os.environ["NGC"])
    last = max(segments)
    held = [(line, p) for line, p in samples if line in segments and line < last]
    near = lambda line, p: min(
        distance(p, *segments[k]) for k in range(line - 2, line + 3) if k in segments
    )
    off = max((near(line, p) for line, p in held), default=float("inf"))
    missed = max(min(distance(p, cut, cut) for _, p in held) for cut in cuts) if held else float("inf")
    verdict = "passed" if off <= TOLERANCE and missed <= TOLERANCE else "FAILED"
    return "%s controller: %d cuts, %d samples, %s; tip at most %.4f mm off its lines, cuts end within %.4f mm" % (
        verdict, len(cuts), len(held), told, off, missed)


try:
    answer = judged()
except Exception as error:  # the controller has to be told to end whatever happened
    answer = "FAILED controller: %s" % error
with open(os.environ["RESULT"], "w") as result:
    result.write(answer + "\n")
