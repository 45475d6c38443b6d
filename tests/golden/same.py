#!/usr/bin/python3
"""usage: same.py BASE_BINARY BINARY FOLDER [REGEX]: runs the cases that match by both and says of each whether its result is the same
bytes, with the same report but for times and memory, or else which figures moved. Fails where one moved, or is refused by one alone."""
import os
import sys

import measured


def without_clocks(report):
    """A report but for what no two runs share."""
    if isinstance(report, dict):
        return {k: without_clocks(v) for k, v in report.items() if k not in ("seconds", "memory_peak_bytes")}
    return [without_clocks(v) for v in report] if isinstance(report, list) else report


def told(name, row, binaries, folder):
    """What moved in a case, line by line; nothing where it is the same."""
    results = []
    for which, binary in zip(("base", "here"), binaries):
        os.makedirs(os.path.join(folder, which), exist_ok=True)
        results.append(measured.run([binary], row, os.path.join(folder, which), name, 3))
    (out, report, why), (new_out, new_report, new_why) = results
    if why or new_why:
        return [] if why and new_why else [f"refused by {'the base' if why else 'this one'} alone: {why or new_why}"]
    report, new_report = without_clocks(report), without_clocks(new_report)
    lines = []
    others = sorted(k for k in {*report, *new_report} if report.get(k) != new_report.get(k))
    if others:
        lines.append("report: " + " ".join(others))
    with open(out, "rb") as old, open(new_out, "rb") as new:
        if old.read() == new.read():
            return lines
    (x, digest), (new_x, new_digest) = measured.positions(out), measured.positions(new_out)
    if digest == new_digest:
        return ["same positions, other attributes or head", *lines]
    for side, points in (("was", x), ("is ", new_x)):
        lines.append("  ".join([side, *measured.line(points, measured.figures(points, row[0]))]) if not measured.UNMEASURED
                     else f"{side} {len(points)} points, not measured: {measured.UNMEASURED}")
    return lines


def main(base, binary, folder, only="."):
    if measured.MISSING:
        sys.exit(measured.MISSING)
    moved = 0
    print("             n  " + "  ".join(measured.FIGURES))
    for name, row in measured.cases(only).items():
        lines = [absent] if (absent := measured.absent(row[0])) else told(name, row, (base, binary), folder)
        moved += bool(lines)
        print(f"{name:12s} {'same' if not lines else 'MOVED'}", *(f"             {line}" for line in lines), sep="\n", flush=True)
    print(f"{moved} cases moved" if moved else "every case is the same")
    return moved > 0


if len(sys.argv) < 4:
    sys.exit(__doc__)
sys.exit(main(*sys.argv[1:]))
