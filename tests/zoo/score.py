#!/usr/bin/python3
"""Is the engine right on shapes that nobody tuned it on? Families with random parameters, and the rules of what is right, are those of
../shared/yardstick/zoo.py, without which this fails. right.txt has the cases that were right: one that is wrong now fails.

usage: score.py [long] [renew] [families=REGEX] [seeds=A-B]

Without `long`, which runs every case and prints the scoreboard, it is a few cases of seed 1. No case is judged by its seconds; the limit
of zoo.py only ends one that hangs. `renew` adds to right.txt what has become right; what has become wrong is taken out by hand."""
import collections
import multiprocessing
import os
import re
import sys

sys.dont_write_bytecode = True
sys.path.append("../shared/yardstick")
try:
    import zoo
except ImportError as error:
    print(f"Bail out! {error} (../shared/yardstick, python3-numpy, python3-scipy)")
    sys.exit(1)

BINARY = os.environ.get("VORONOID", "build/release/voronoid")
RIGHT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "right.txt")
ASKED = dict(word.partition("=")[::2] for word in sys.argv[1:])
LONG = "long" in ASKED
# Without `long`: one family of each kind (flat faces, round, thin, parts, open), and the cases that cost least to make and measure.
FAMILIES = ("polyhedron", "torus", "thin", "near_contact", "wavy", "gear")
CASES = ("resample", "upsample", "mesh", "denoise")


def tasks():
    """Family, seed and cases (None: all) of each task."""
    low, _, high = ASKED.get("seeds", "1-5" if LONG else "1").partition("-")
    names = [name for name in zoo.FAMILIES if LONG or name in FAMILIES if re.search(ASKED.get("families", "."), name)]
    return [(name, seed, None if LONG else CASES) for seed in range(int(low), int(high or low) + 1) for name in names]


def run(task):
    """The rows of a family and a seed."""
    name, seed, cases = task
    folder = f"build/zoo/{name}-{seed}"
    os.makedirs(folder, exist_ok=True)
    return zoo.score(BINARY, [name], [seed], "full", cases, folder, keep=False, progress=False)


def verdicts(rows):
    """Right cases, and again, with a star, those whose normals are right."""
    right = {(row["family"], row["seed"], row["case"]) for row in rows if not row["wrong"]}
    return right | {(row["family"], row["seed"], row["case"] + "*") for row in rows if row["normals"] == {}}


def told():
    with open(RIGHT) as file:
        lines = [line.split(":") for line in file if not line.startswith("#")]
    return {(head.split()[0], int(head.split()[1]), case) for head, cases in lines for case in cases.split()}


def renew(right):
    with open(RIGHT) as file:
        head = [line for line in file if line.startswith("#")]
    cases = collections.defaultdict(list)
    for name, seed, case in sorted(right):
        cases[name, seed].append(case)
    with open(RIGHT, "w") as file:
        file.writelines(head + [f"{name} {seed}: {' '.join(each)}\n" for (name, seed), each in sorted(cases.items())])


def main():
    kept, rows, failed, asked = told(), [], False, tasks()
    print(f"1..{len(asked)}")
    with multiprocessing.Pool(int(os.environ.get("JOBS", 1))) as pool:
        for number, (task, some) in enumerate(zip(asked, pool.imap(run, asked)), 1):
            wanted = {c for n, s, c in kept if (n, s) == task[:2] and (LONG or c.rstrip("*") in CASES)}
            lost = sorted(wanted - {c for _, _, c in verdicts(some)})  # what did not run is lost too
            print(f"{'not ' * bool(lost)}ok {number} - {task[0]} {task[1]}: what was right is right", flush=True)
            for line in zoo.failures([{**row, "slow": None} for row in some if {row["case"], row["case"] + "*"} & {*lost}]):
                print("#", line.replace("\n", "\n# "))
            failed, rows = failed or bool(lost), rows + some
            if "renew" in ASKED:
                renew(kept | verdicts(rows))
    if LONG:
        zoo.show(rows)
    return failed


if __name__ == "__main__":
    sys.exit(main())
