#!/usr/bin/python3
"""usage: page.py VORONOID OUT: the page in chromium without a screen: first paint, from dropping 2 M points to seeing them, frames a second
while they are turned. Writes OUT/page.md, and pictures of each state of the page into OUT/page."""
import glob
import os
import statistics
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.join(HERE, "..", "..", "page"))
os.environ["VORONOID"] = sys.argv[1]
import pictures  # noqa: E402
from browser import Browser, By, Daemon, wait  # noqa: E402
from made import torus  # noqa: E402

RUNS = int(os.environ.get("RUNS", "5"))
POINTS = 2_000_000
TURN_SECONDS = 4

DROPPED = """
const [name, wanted, done] = arguments, canvas = document.getElementById('canvas'), began = performance.now();
let first = 0;
const look = () => {
    if (document.getElementById('cloud-words').textContent.startsWith(name + ': ') && Number(canvas.dataset.drawn)) {
        first = first || performance.now() - began;
        if (Number(canvas.dataset.drawn) === wanted) return done([first, performance.now() - began]);
    }
    return requestAnimationFrame(look);
};
requestAnimationFrame(look);
"""
TURNED = """
const [seconds, done] = arguments, canvas = document.getElementById('canvas'), box = canvas.getBoundingClientRect(), most = [];
const at = (kind, x) => canvas.dispatchEvent(new MouseEvent(kind, { bubbles: true, clientX: x, clientY: box.top + box.height / 2, button: 0 }));
const say = (kind, x) => document.dispatchEvent(new MouseEvent(kind, { bubbles: true, clientX: x, clientY: box.top + box.height / 2, button: 0 }));
let x = box.left + 50, first = Number(canvas.dataset.frames), began = performance.now();
at('mousedown', x);
const move = () => {
    say('mousemove', x += 3);
    most.push(Number(canvas.dataset.drawn));
    if (performance.now() - began < 1000 * seconds) return requestAnimationFrame(move);
    say('mouseup', x);
    return done([(Number(canvas.dataset.frames) - first) / (performance.now() - began) * 1000, most.at(-1)]);
};
requestAnimationFrame(move);
"""


def painted(url):
    browser = Browser()
    try:
        browser.open(url)
        wait("a first paint", lambda: browser.script("return performance.getEntriesByName('first-contentful-paint').length"))
        return browser.script("return performance.getEntriesByName('first-contentful-paint')[0].startTime")
    finally:
        browser.close()


def large(url, path):
    """Milliseconds from choosing the file to its first points on the screen and to all; frames a second while turning, and points of such a
    frame."""
    browser = Browser()
    try:
        browser.driver.set_script_timeout(120)
        browser.open(url)
        wait("the form", lambda: browser.driver.find_elements(By.ID, "ask-points"))
        browser.choose(path)
        first, whole = browser.driver.execute_async_script(DROPPED, os.path.basename(path), POINTS)
        browser.driver.execute_async_script("setTimeout(arguments[0], 15000)")  # normals and spacings are measured meanwhile
        frames, drawn = browser.driver.execute_async_script(TURNED, TURN_SECONDS)
        return first, whole, frames, drawn
    finally:
        browser.close()


def row(words, values, unit):
    return f"| {words} | {statistics.median(values):.3g} {unit} | {min(values):.3g} to {max(values):.3g} |"


def main(out):
    os.makedirs(f"{out}/clouds", exist_ok=True)
    path = f"{out}/clouds/torus2m.ply"
    if not os.path.exists(path):
        with open(path, "wb") as cloud:
            cloud.write(torus(POINTS))
    daemon = Daemon()
    try:
        paints = [painted(daemon.url) for _ in range(RUNS)]
        rows = [large(daemon.url, path) for _ in range(RUNS)]
    finally:
        daemon.stop()
    lines = ["## The page, in chromium that draws by software", "", "| what | median | spread |", "|---|---|---|",
             row("first paint on loopback", paints, "ms"), row("2 M points (54 MB) from choosing the file to the first of them on the screen", [one[0] for one in rows], "ms"),
             row("and to all of them", [one[1] for one in rows], "ms"),
             row("frames a second while they are turned", [one[2] for one in rows], ""), row("points of such a frame", [one[3] for one in rows], ""), "",
             f"{RUNS} runs, load {os.getloadavg()[0]:.1f} on {os.cpu_count()} cores.", ""]
    with open(f"{out}/page.md", "w", encoding="utf-8") as text:
        text.write("\n".join(lines))
    print("\n".join(lines))
    clouds = [name for name in (f"../shared/data/{one}.ply" for one in ("bunny", "autzen", "scannet")) if glob.glob(name)]
    if clouds and not os.environ.get("NO_PICTURES"):
        pictures.main(f"{out}/page", clouds)


main(sys.argv[2])
