#!/usr/bin/python3
"""What the cases of cases.txt come to: at three threads the points that figures.txt has, which were made by one; figures that are
those written there (measured where the points are others, and in `make soak`); and none worse than bounds.txt allows. `make
golden` writes the figures anew. Under a sanitizer, which changes no result, the points alone of one case for each method. In `make
soak`: at 1, 2, 3 and 8 threads."""
import os
import re
import shlex
import sys
import tempfile

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import measured  # noqa: E402

BINARY = shlex.split(os.environ.get("VORONOID", "build/release/voronoid"))  # or an emulator before it
THREADS = (1, 2, 3, 8) if "VT_SOAK" in os.environ else (3,)
IS_SANITIZED = re.search("asan|tsan", " ".join(BINARY))
IS_BARE = IS_SANITIZED or "qemu" in BINARY[0]
METHODS = "^(ball|fill|curvature|anisotropic|lp|kmeans|wlop|ear|mesh)$"
ONLY = os.environ.get("ONLY", METHODS if IS_SANITIZED else ".")


def faults(name, row, kept, worst, folder):
    """What is wrong with a case, line by line."""
    for threads in THREADS:
        out, _, why = measured.run(BINARY, row, folder, name, threads)
        if why:
            return [why]
        x, digest = measured.positions(out)
        if digest != kept[0]:
            break
    wrong = [] if digest == kept[0] else [f"other points at {threads} threads: {digest} and not {kept[0]}"]
    if measured.UNMEASURED and not IS_BARE:
        wrong += [f"cannot be measured: {measured.UNMEASURED}"] if os.environ.get("CI") else []
    if IS_BARE or measured.UNMEASURED:
        return wrong
    if not wrong and "VT_SOAK" not in os.environ:  # the same points have the same figures
        return measured.beyond(kept[1:], worst)
    fresh = measured.line(x, measured.figures(x, row[0]))
    if fresh != kept[1:]:
        wrong += ["figures now:     " + "  ".join(fresh), "in figures.txt:  " + "  ".join(kept[1:])]
    return wrong + measured.beyond(fresh, worst)


def main():
    if measured.MISSING:
        needed = bool(os.environ.get("CI"))
        print(f"1..0 # SKIP {measured.MISSING}" if not needed else f"Bail out! {measured.MISSING}, and CI is set")
        return needed
    kept, worst = measured.table("figures.txt"), measured.table("bounds.txt")
    others = {*measured.cases()} ^ {*kept} | {*measured.cases()} ^ {*worst}
    if others:
        print("Bail out! cases.txt, figures.txt and bounds.txt do not all have:", *sorted(others))
        return True
    asked, failed = measured.cases(ONLY), False
    print(f"1..{len(asked)}")
    if measured.UNMEASURED:
        print(f"# points alone, no figures: {measured.UNMEASURED}")
    with tempfile.TemporaryDirectory() as folder:
        for number, (name, row) in enumerate(asked.items(), 1):
            absent = measured.absent(row[0])
            if absent and not os.environ.get("CI"):
                print(f"ok {number} - {name} # SKIP {absent}")
                continue
            wrong = [absent] if absent else faults(name, row, kept[name], worst[name], folder)
            failed |= bool(wrong)
            print(f"{'not ok' if wrong else 'ok'} {number} - {name}", *(f"# {line}" for line in wrong), sep="\n", flush=True)
    return failed


sys.exit(1 if main() else 0)
