#!/usr/bin/python3
"""usage: renew.py BINARY FOLDER figures|bounds [REGEX]: writes figures.txt or bounds.txt anew for the cases that match, and shows what
they were. A result that depends on the number of threads is not written down.

Bounds are what another seed may come to: the mean over SEEDS seeds and SDS standard deviations of them, towards the worse. A change that
moves points without making them worse is like another seed; with 130 bounds one in ten such changes trips one of them (Student's t).
A bound LOW..HIGH, towards both sides, stands where the figure says how much the spacing or the shape of cells was asked to vary."""
import math
import multiprocessing
import os
import sys

import measured

SEEDS, SDS = 16, 4


def figures_of(name, row, command, folder, kept):
    """The line of a case, anew."""
    digests = []
    for threads in (1, 3):
        out, _, why = measured.run(command, row, folder, name, threads)
        if why:
            sys.exit(f"{name}: {why}")
        x, digest = measured.positions(out)
        digests.append(digest)
    if digests[0] != digests[1]:
        sys.exit(f"{name}: {digests[0]} at one thread, {digests[1]} at three")
    return [digest, *measured.line(x, measured.figures(x, row[0]))]


def outwards(form, value, side):
    """The number as it is shown, rounded away from the better: side is 1 for up."""
    text = form % value
    if (float(text) - value) * side < 0:
        unit = 10.0 ** (int(text.split("e")[1]) - 2) if "e" in text else 10.0 ** -len(text.split(".")[1])
        text = form % (float(text) + side * unit)
    return text


def drawn_by(seed, name, row, command, folder):
    """Figures of a case with another seed."""
    folder = os.path.join(folder, str(seed))
    os.makedirs(folder, exist_ok=True)
    out, _, why = measured.run(command, row, folder, name, 1, "--seed", str(seed))
    if why:
        raise RuntimeError(f"{name}: {why}")
    return measured.figures(measured.positions(out)[0], row[0])


def bounds_of(name, row, command, folder, kept):
    """The bounds of a case, anew. Those of both sides, and those that are none, stay so."""
    with multiprocessing.Pool() as pool:
        drawn = pool.starmap(drawn_by, [(seed, name, row, command, folder) for seed in range(1, SEEDS + 1)])
    bounds = []
    for k, (figure, (form, better)) in enumerate(measured.FIGURES.items()):
        values = [one[figure] for one in drawn]
        if values[0] is None or kept and kept[k] == "-":
            bounds.append("-")
            continue
        mean = math.fsum(values) / SEEDS
        apart = SDS * math.sqrt(math.fsum((v - mean) ** 2 for v in values) / (SEEDS - 1))
        low, high = outwards(form, max(0.0, mean - apart), -1), outwards(form, mean + apart, 1)
        one_side = (low if float(low) > 0 else "-") if better > 0 else high  # a bound of 0 says nothing
        bounds.append(f"{low}..{high}" if kept and ".." in kept[k] else one_side)
    return bounds


def main(binary, folder, what, only="."):
    if measured.MISSING or measured.UNMEASURED:
        sys.exit(measured.MISSING or measured.UNMEASURED)
    os.makedirs(folder, exist_ok=True)
    kept, worst = measured.table(f"{what}.txt"), measured.table("bounds.txt")
    names = list(measured.cases())
    fresh = {name: row for name, row in kept.items() if name in names}
    for name, row in measured.cases(only).items():
        fresh[name] = (figures_of if what == "figures" else bounds_of)(name, row, [binary], folder, kept.get(name))
        if fresh[name] == kept.get(name):
            continue
        print(f"{name}\n  was  {'  '.join(kept.get(name, ['not there']))}\n  is   {'  '.join(fresh[name])}")
        if what == "figures" and name in worst:
            for line in measured.beyond(fresh[name][1:], worst[name]):
                print(f"  WORSE THAN ALLOWED: {line}")
        sys.stdout.flush()
    measured.write(f"{what}.txt", {name: fresh[name] for name in names if name in fresh})


if len(sys.argv) < 4:
    sys.exit(__doc__)
main(*sys.argv[1:])
