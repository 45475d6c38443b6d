#!/usr/bin/python3
"""The page in a browser before the daemon: what a person does with it, and that nothing goes wrong meanwhile. Pictures of what was
seen are in build/page."""
import gzip
import hashlib
import json
import os
import re
import sys
import traceback
import urllib.request

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import pictures  # noqa: E402
from browser import ActionChains, Browser, By, Daemon, wait  # noqa: E402
from claims import PICTURES, Abandoned, ask, charted, claim, deltas, drawn, drop, equal, finished, ok, run_to_end, shows  # noqa: E402
from docs import documentation  # noqa: E402
from jobs import cancelled_upload, eight_tabs, failed_job, line, long_job, reload_and_stop, unanswered  # noqa: E402
from made import FAR, lines, mesh, torus  # noqa: E402

CLOUDS = [f"../shared/data/{name}.ply" for name in ("bunny", "autzen", "scannet")]  # every state of them is pictured in a soak
PAGE_BYTES_MAX = 250_000
KEY = "a key of somebody's"
MANY = 310_000  # points of a large cloud
SHIFTS_MAX = 0.1  # layout shifts that web.dev calls good
CONTRAST_MIN = 4.5  # WCAG 2.1, 1.4.3
FOCUSABLE = "a[href], button, input, select, summary, canvas[tabindex], pre[tabindex]"


def first_look(browser):
    browser.driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", {"width": 390, "height": 844, "deviceScaleFactor": 1, "mobile": True})
    place = browser.script("return document.getElementById('file').getBoundingClientRect().bottom")
    ok(0 < place < 300, "on a phone the file comes first, before a picture of nothing", place)
    browser.driver.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})


def drop_to_result(browser):
    browser.driver.refresh()  # so that all that moves is counted
    wait("the form", lambda: browser.driver.find_elements(By.ID, "ask-points"))
    drop(browser, torus(4000, FAR), "far away's torus.ply")
    shows(browser, "cloud-words", "4,000 points")
    wait("the cloud is drawn", lambda: drawn(browser) == 4000)
    browser.listen()
    posts = [url for url in browser.requests if "name=" in url]
    equal(posts, [], "a cloud is shown before any of it is sent")
    equal(browser.element("ask-points").get_property("value"), "10000", "the form has something to run before anybody filled it")
    pressed = lambda: browser.script("return [...document.querySelectorAll('#presets [aria-pressed=true]')].map((one) => one.textContent)")
    equal(pressed(), ["Even 10,000"], "which is the first preset")
    ask(browser, points=1000)
    equal(pressed(), [], "and no longer once it was filled otherwise")
    run_to_end(browser)
    ok(wait("the chart", lambda: charted(browser) >= 5), "the chart of a short job has five points or more")
    ok("4,000 → 1,000 points" in browser.text("summary"), "the summary has the points that came and went", browser.text("summary"))
    report = browser.script("return document.getElementById('report').textContent")
    ok(re.search(r"Distance to the input[\d.e-]+ unit of the cloudMean.*Hausdorff distance[\d.e-]+ unit.*The largest", report) is not None,
       "the report begins with the figures most people look for, each with its meaning", report[:300])
    wait("the page's own figure", lambda: "δ" in browser.text("caption-result"))
    ok(wait("the last frame of the chart", lambda: len(set(deltas(browser))) == 1), "headline, picture and chart tell the same delta")
    missed = browser.script("return [...document.querySelectorAll('#report dd')].filter((one) => !one.querySelector('.meaning'))"
                            ".map((one) => one.previousSibling.textContent)")
    equal(missed, [], "and so has every figure, and every parameter")
    wait("both are drawn", lambda: drawn(browser) == 5000)
    shifted, movers = browser.script("return [window.shifted, window.movers]")
    ok(shifted <= SHIFTS_MAX, "opened, run and done, nothing moved under a hand", movers)
    browser.driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", {"width": 1280, "height": 800, "deviceScaleFactor": 1, "mobile": False})
    low, high = browser.script("""
        document.getElementById('report-box').open = true;
        const low = document.getElementById('takers').getBoundingClientRect().bottom, high = document.documentElement.scrollHeight;
        document.getElementById('report-box').open = false;
        return [low, high];""")
    ok(low < 800 and high < 2400, "at 1280x800 what can be downloaded is in sight, and a report that is opened makes no endless page", (low, high))
    browser.picture(f"{PICTURES}/result.png")
    browser.driver.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})


def compare(browser):
    shown = lambda: browser.script("return document.querySelector('input[name=layout]:checked').value")
    equal(shown(), "both", "input and result stand side by side")
    browser.element("canvas").send_keys(" ")
    ring = browser.script("const one = getComputedStyle(document.getElementById('canvas')); return parseFloat(one.outlineWidth) + parseFloat(one.outlineOffset)")
    ok(ring <= 0, "the ring around a view that has the focus lies in its box, where it is seen", ring)
    first = shown()
    browser.element("canvas").send_keys(" ")
    equal({first, shown()}, {"input", "result"}, "the space bar changes between them")
    browser.driver.find_element(By.CSS_SELECTOR, "input[name=layout]:checked").send_keys(" ")
    equal(shown(), first, "also where the layout was chosen last")
    browser.driver.find_element(By.CSS_SELECTOR, "input[name=layout][value=swipe]").click()
    ActionChains(browser.driver, duration=0).click_and_hold(browser.element("divider")).move_by_offset(80, 0).release().perform()
    width, split = browser.element("canvas").size["width"], float(browser.element("split").get_property("value"))
    ok(abs(split - 0.5 - 80 / width) < 0.02, "the divider goes where it is dragged to", (split, width))
    browser.driver.find_element(By.CSS_SELECTOR, "input[name=layout][value=both]").click()
    equal(re.sub(r", δ\s[\d.]+", "", browser.text("captions")).split("\n"), ["input: 4,000 points", "result: 1,000 points"], "each side says what it is")
    equal((browser.element("mode").get_property("value"), browser.element("style").get_property("value")), ("spacing", "dots"),
          "in dots that are coloured by their spacing")
    for mode in ("distance", "spacing"):
        browser.script("const m = document.getElementById('mode'); m.value = arguments[0]; m.dispatchEvent(new Event('change'));", mode)
        shows(browser, "histogram-caption", "divided by the mean" if mode == "spacing" else "point of the input")
        text = browser.element("histogram-canvas").get_attribute("aria-label")
        equal(re.findall(r"(\w+): ([\d,]+) points", text), [("input", "4,000")] * (mode == "spacing") + [("result", "1,000")],
              f"coloured by {mode}, there is a histogram for each cloud that has such figures")
    browser.script("const m = document.getElementById('mode'); m.value = 'distance'; m.dispatchEvent(new Event('change'));")
    shows(browser, "histogram-caption", "point of the input")
    most = float(re.search(r"from 0 to ([\d.e-]+)", browser.element("histogram-canvas").get_attribute("aria-label"))[1])
    ok(0 < most < 0.2, "far from zero the result lies on the input, in doubles: float32 has steps of 0.5 there", most)


def take_away(browser):
    browser.script("document.getElementById('commands').open = true")
    browser.driver.find_element(By.CSS_SELECTOR, "[data-language=curl]").click()
    wait("a command", lambda: browser.element("command").is_displayed())
    text = browser.text("command")
    ok("'@far away'\\''s torus.ply'" in text and "points=1000" in text, "a command has the file's name as a shell wants it", text)
    browser.script("document.getElementById('commands').open = false")
    names = browser.script("""
        const names = [], blobs = [], kept = URL.createObjectURL;
        HTMLAnchorElement.prototype.click = function () { names.push(this.download); };
        URL.createObjectURL = (blob) => { blobs.push(blob); return kept.call(URL, blob); };
        [window.names, window.blobs] = [names, blobs];
        document.getElementById('report-box').open = true;
        return [...document.querySelectorAll('#takers button, #more-takers button')].map((one) => one.textContent);""")
    equal(names[:2], ["Download PLY", "Download Draco"], "the result can be had as PLY and as Draco")
    for button in browser.driver.find_elements(By.CSS_SELECTOR, "#takers button, #more-takers button") + [browser.element("png")]:
        button.click()
    saved = wait("all files are saved", lambda: len(browser.script("return window.names")) == len(names) + 1 and browser.script("return window.names"))
    equal(sorted(saved), sorted(f"far away's torus.{end}" for end in ("resample.ply", "resample.drc", "report.json", "metrics.csv", "chart.png", "png")),
          "files are named after the input")
    begins = browser.driver.execute_async_script("""
        const done = arguments[0];
        Promise.all(window.blobs.map(async (blob) => new TextDecoder('latin1').decode(await blob.slice(0, 10).arrayBuffer()))).then(done);""")
    browser.script("document.getElementById('report-box').open = false")
    wanted = {"ply": "ply\n", "drc": "DRACO", "json": "{", "csv": "iteration,", "png": "\u2030PNG"}
    equal([name for name, text in zip(saved, begins) if not text.startswith(wanted[name.split(".")[-1]])], [], "and hold what they are called")


def reached(browser):
    """The ids (or words) of what the tab key leads to, once around."""
    browser.script("document.activeElement.blur(); window.reached = new Set();"
                   "document.addEventListener('focusin', (event) => window.reached.add(event.target));")
    for _ in range(30):
        before = browser.script("return window.reached.size")
        browser.tab(10)
        if browser.script("return window.reached.size") == before:
            break


def spoken(browser):
    """Role and name of each control as a screen reader is told them."""
    nodes = browser.driver.execute_cdp_cmd("Accessibility.getFullAXTree", {})["nodes"]
    can = lambda node: any(one["name"] == "focusable" and one["value"].get("value") for one in node.get("properties", []))
    return [(node["role"]["value"], node.get("name", {}).get("value", "").strip()) for node in nodes
            if not node["ignored"] and can(node) and node["role"]["value"] not in ("RootWebArea", "option")]


def reachable(browser):
    browser.script("document.querySelectorAll('details').forEach((one) => { one.open = true; })")
    reached(browser)
    missed = browser.script(f"""
        const groups = new Set([...window.reached].filter((one) => one.type === 'radio').map((one) => one.name));
        return [...document.querySelectorAll('{FOCUSABLE}')].filter((one) => one.checkVisibility() && !one.disabled
            && !window.reached.has(one) && !groups.has(one.name || '')).map((one) => one.outerHTML.slice(0, 90));""")
    equal(missed, [], "the tab key leads to every control")
    names = spoken(browser)
    equal([role for role, name in names if not name], [], "every control has a name that is spoken")
    ok(len(names) > 60, "with all that is folded away, there are many of them", len(names))
    browser.script("for (const one of ['process', 'ask-points']) document.querySelector(`label[for=${one}]`).htmlFor += '-not'")
    equal(sorted(role for role, name in spoken(browser) if not name), ["combobox", "spinbutton"], "and of two whose labels are taken away this is seen")
    browser.script("for (const one of ['process', 'ask-points']) document.querySelector(`label[for=${one}-not]`).htmlFor = one")
    browser.script("document.querySelectorAll('details').forEach((one) => { one.open = false; })")


def form(browser):
    """What a parameter hangs on decides whether it is shown and sent."""
    choose = lambda name, value: browser.script("const one = document.getElementById(arguments[0]); one.value = arguments[1];"
                                                "one.dispatchEvent(new Event('input', { bubbles: true }));", name, value)
    seen = lambda: browser.script("return document.getElementById('ask-sigmaN').closest('.field').hidden === false")
    high = browser.script("return document.getElementById('ask').offsetHeight")
    ok(high < 500, "the form shows what most people need, the rest is folded", high)
    browser.script("document.querySelector('#fields .field:not([hidden]) .about').click()")
    shows(browser, "ask-points-help", "1 to 10,000,000 points")
    ways = [browser.script("""
        document.querySelector(`#fields input[type=radio][value=${arguments[0]}]`).click();
        return [...document.querySelectorAll('#fields .field:not([hidden]) input[type=number]')].map((one) => one.id)
            .filter((id) => /^ask-(points|ratio|spacing)$/.test(id));""", name) for name in ("ratio", "spacing", "points")]
    equal(ways, [["ask-ratio"], ["ask-spacing"], ["ask-points"]], "how many points is one choice and one number")
    before = seen()
    choose("ask-method", "ear")
    equal((before, seen()), (False, True), "parameters of a method are there once it is chosen")
    choose("ask-sigmaN", "20")
    browser.script("document.querySelector('[data-language=curl]').click()")
    with_it = browser.script("return document.getElementById('command').textContent")
    choose("ask-method", "")
    browser.script("document.querySelector('[data-language=curl]').click()")
    without = browser.script("return document.getElementById('command').textContent")
    ok("sigmaN=20" in with_it and "sigmaN" not in without, "and are asked for only then", without)


SEEN = """
const done = arguments[0], kept = URL.createObjectURL, clicked = HTMLAnchorElement.prototype.click;
HTMLAnchorElement.prototype.click = () => {};
URL.createObjectURL = (blob) => {
    [URL.createObjectURL, HTMLAnchorElement.prototype.click] = [kept, clicked];
    createImageBitmap(blob).then((picture) => {
        const { width, height } = picture, pen = Object.assign(document.createElement('canvas'), { width, height }).getContext('2d');
        pen.drawImage(picture, 0, 0);
        const pixels = new Uint32Array(pen.getImageData(0, 0, width, height).data.buffer), ground = pixels[0];
        let [left, right, rows, inside, holes] = [width, 0, 0, 0, 0];
        for (let y = 0; y < height; y++) {
            const row = pixels.subarray(y * width, (y + 1) * width), first = row.findIndex((one) => one !== ground);
            const last = row.findLastIndex((one) => one !== ground);
            if (first < 0) continue;
            [left, right, rows] = [Math.min(left, first), Math.max(right, last), rows + 1];
            inside += last - first + 1;
            holes += row.subarray(first, last + 1).filter((one) => one === ground).length;
        }
        done([(right - left) / width, rows / height, holes / inside]);
    });
    return '';
};
document.getElementById('png').click();
"""


def surface(browser):
    """A sheet as a scanner has it, and a mesh."""
    drop(browser, lines(), "lines.ply")
    shows(browser, "cloud-words", "10,800 points")
    draw = lambda style: browser.script("const m = document.getElementById('style'); m.value = arguments[0]; m.dispatchEvent(new Event('change'));", style)
    seen = lambda: browser.driver.execute_async_script(SEEN)
    with claim("dots do not touch"):
        wait("gaps", lambda: seen()[2] > 0.3)
    draw("discs")
    wait("a surface", lambda: seen()[2] < 0.02)
    wide, high, _ = seen()
    ok(0.85 < max(wide, high) < 1, "a cloud of lines three spacings apart is drawn as a surface, as large as there is room", (wide, high))
    drop(browser, mesh(), "sheet.ply")
    shows(browser, "cloud-words", "144 points, 242 triangles")
    wait("its triangles", lambda: drawn(browser) >= 242)
    shows(browser, "mesh-words", "The vertices of the mesh are the input")
    browser.script("document.getElementById('mesh-turn').click()")
    shows(browser, "mesh-words", "Points that are sampled from the faces are the input")
    ask(browser, points=100)
    run_to_end(browser)
    report = json.loads(browser.script("""
        const request = new XMLHttpRequest();
        request.open('GET', `v1/jobs/${arguments[0]}/results/report`, false);
        request.send();
        return request.responseText;""", browser.driver.current_url.split("/")[-1]))
    ok(report["samples"] >= 800, "of a mesh the faces can be taken, as the page says", report["samples"])
    choose = lambda name: browser.script("const one = document.getElementById('process'); one.value = arguments[0]; one.dispatchEvent(new Event('change'));", name)
    choose("mesh")
    equal(browser.element("ask-points").get_property("value"), "10000", "each process has its own form")
    ask(browser, points=60)
    run_to_end(browser)
    browser.script("const m = document.getElementById('mode'); m.value = 'distance'; m.dispatchEvent(new Event('change'));")
    shows(browser, "histogram-caption", "point of the input")
    browser.driver.find_element(By.CSS_SELECTOR, "input[name=layout][value=result]").click()
    shown = lambda: browser.script("return document.querySelector('input[name=layout]:checked').value") == "result" and drawn(browser) > 60
    ok(wait("triangles in colours", shown), "the triangles of a result are drawn, and coloured")
    draw("surface")
    browser.picture(f"{PICTURES}/mesh.png")
    draw("dots")  # which software draws far sooner
    choose("resample")


def many_points(browser, folder):
    """More points than are drawn while the view moves."""
    path, rows = f"{folder}/many.ply", torus(MANY // 31)
    head, body = rows.split(b"end_header\n", 1)
    with open(path, "wb") as out:
        out.write(head.replace(b"vertex %d" % (MANY // 31), b"vertex %d" % MANY) + b"end_header\n" + body * 31)
    browser.choose(path)
    wait("all points of a view at rest", lambda: drawn(browser) == MANY)
    canvas = browser.element("canvas")
    ActionChains(browser.driver, duration=0).click_and_hold(canvas).move_by_offset(30, 5).perform()
    few = wait("fewer", lambda: drawn(browser) < MANY and drawn(browser))
    ActionChains(browser.driver, duration=0).release().perform()
    wait("all of them again", lambda: drawn(browser) == MANY)
    ok(30_000 <= few <= 300_000, f"of {MANY} points 300,000 at most are drawn while the view is turned, all of them when it rests", few)


def bad_files(browser):
    drop(browser, b"hello there, this is no cloud", "letter.txt")
    for cloud, name, words in ((b"hello there, this is no cloud", "letter.txt", "hello there"), (torus(100)[:-40], "short.ply", "vertex")):
        drop(browser, cloud, name)
        with claim(f"{name} is refused in the daemon's words, and the page says what to do"):
            shows(browser, "trouble", words)
            shows(browser, "cloud-words", f"{name} cannot be used. Choose another file")
        ok(not browser.element("run").is_enabled(), "and it cannot be run")
    drop(browser, torus(500), "small.ply")
    shows(browser, "cloud-words", "500 points")
    equal(browser.text("trouble"), "", "another file takes the words away")
    ask(browser, points=0)
    browser.element("run").click()
    ok(not browser.element("ask-points").get_property("validity")["valid"], "a number out of range stays on the page")
    browser.element("ask-points").clear()
    browser.element("run").click()
    shows(browser, "ask-points-wrong", "give exactly one of the parameters points, ratio and spacing: none is given")
    equal(browser.script("return document.activeElement.id"), "ask-points", "what is refused is said beside the field, which is gone to")


def other_format(browser, daemon):
    request = urllib.request.Request(f"{daemon.url}/v1/convert?format=drc", torus(800))
    with urllib.request.urlopen(request) as answer:
        drop(browser, answer.read(), "packed.drc")
    shows(browser, "cloud-words", "packed.drc: 800 points")
    ask(browser, points=300)
    run_to_end(browser)
    ok("800 → 300 points" in browser.text("summary"), "a Draco file is shown, and run without sending it again", browser.text("summary"))


def reference(browser, daemon):
    """A second cloud, to be measured against."""
    choose = lambda name: browser.script("const one = document.getElementById('process'); one.value = arguments[0]; one.dispatchEvent(new Event('change', { bubbles: true }));", name)
    path = os.path.join(daemon.folder.name, "the other.ply")
    with open(path, "wb") as out:
        out.write(torus(900, seed=2))
    choose("measure")
    browser.element("ask-reference").send_keys(path)
    browser.element("run").click()
    shows(browser, "watch-title", "measure")
    wait("figures", lambda: browser.element("report-box").is_displayed())
    text = browser.script("return document.getElementById('report').textContent")
    ok("input · hausdorff" in text, "a cloud is measured beside another one, which the form takes", text[:400])
    browser.script("document.querySelector('[data-language=curl]').click()")
    text = browser.script("return document.getElementById('command').textContent")
    ok("'reference=@\"the other.ply\"'" in text, "which is in the command", text)
    drop(browser, torus(1200, seed=3, turned=True), "turned.ply")
    choose("register")
    browser.element("ask-reference").send_keys(path)
    wait("both are drawn", lambda: drawn(browser) == 2100)
    browser.element("run").click()
    with claim("two scans are put together: the reference is drawn beside the cloud, before and after, and said"):
        wait("all are drawn", lambda: drawn(browser) == 2 * 2100)
        shows(browser, "caption-reference", "reference: 900 points")
    browser.picture(f"{PICTURES}/register.png")
    choose("resample")
    wait("the reference is away", lambda: drawn(browser) == 2400)


CONTRASTS = """
const parts = (color) => (color.match(/[\\d.]+/g) || []).map(Number);
const light = (color) => parts(color).slice(0, 3).reduce((sum, one, k) => {
    const c = one / 255;
    return sum + [0.2126, 0.7152, 0.0722][k] * (c <= 0.03928 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4);
}, 0);
const ground = (one) => (parts(getComputedStyle(one).backgroundColor)[3] === 0 ? ground(one.parentElement) : getComputedStyle(one).backgroundColor);
const all = [...document.querySelectorAll('body *')].filter((one) => one.checkVisibility() && !one.disabled && one.type !== 'file'
    && ([...one.childNodes].some((node) => node.nodeType === 3 && node.data.trim()) || /INPUT|SELECT/.test(one.tagName)));
return all.map((one) => {
    const [a, b] = [light(getComputedStyle(one).color), light(ground(one))].sort((x, y) => y - x);
    return [(a + 0.05) / (b + 0.05), one.outerHTML.slice(0, 60)];
}).sort((x, y) => x[0] - y[0]);
"""


def readable(browser, theme):
    rows = browser.script(CONTRASTS)
    ok(len(rows) > 50 and rows[0][0] >= CONTRAST_MIN, f"every word of the page is readable, {theme}", rows[:3])


def appearance(browser):
    equal(browser.script("return document.documentElement.dataset.theme"), "light", "the page is light where the system is")
    browser.script("document.getElementById('report-box').open = true")
    readable(browser, "light")
    browser.element("theme").click()
    equal(browser.script("return document.documentElement.dataset.theme"), "dark", "and dark when asked to be")
    readable(browser, "dark")
    browser.script("document.getElementById('report-box').open = false")
    browser.picture(f"{PICTURES}/dark.png")
    ticks = browser.script("""
        const one = document.getElementById('histogram-canvas'), all = one.getContext('2d').getImageData(0, one.height - 13, one.width, 13).data;
        return Math.max(...all.filter((value, k) => k % 4 === 0 && all[k + 3] > 200));""")
    ok(ticks > 140, "figures below a histogram are as bright then", ticks)
    browser.driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", {"width": 390, "height": 844, "deviceScaleFactor": 1, "mobile": True})
    wide = browser.script("return document.documentElement.scrollWidth")
    ok(wide <= 390, "on a phone nothing is wider than the screen", wide)
    rows = browser.script("""
        const tops = [...document.querySelectorAll('#looks > :not(.break)')].filter((one) => one.checkVisibility()).map((one) => one.getBoundingClientRect());
        return new Set(tops.map((one) => Math.round((one.top + one.bottom) / 16))).size;""")
    ok(rows <= 3, "and what the view offers has three rows", rows)
    browser.picture(f"{PICTURES}/phone.png")
    browser.driver.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})


def history(browser):
    listed = lambda: browser.script("return [...document.querySelectorAll('#history li')].map((one) => one.textContent)")
    rows = wait("the list of jobs", lambda: any("packed.drc: resample" in row for row in listed()) and listed())
    ok(any("one place.ply: resample" in row for row in rows), "the jobs of the daemon are listed", rows)
    browser.driver.execute_async_script("fetch('v1/inspect?name=elsewhere', { method: 'POST', body: arguments[0] }).then(arguments[1])", mesh().decode())
    with claim("those begun elsewhere come by themselves"):
        wait("it", lambda: any("elsewhere: inspect" in row for row in listed()))
    last = browser.script("""
        const all = document.querySelectorAll('#history a'), one = all[all.length - 1];
        [window.shifted, window.movers] = [0, []];
        scrollTo(0, document.documentElement.scrollHeight);
        one.click();
        return one.hash;""")
    with claim("and one can be opened again"):
        wait("another job", lambda: browser.driver.current_url.endswith(last))
        finished(browser)
    wait("its figure", lambda: "δ" in browser.text("caption-result"))
    shifted, at, movers = browser.script("return [window.shifted, scrollY, window.movers]")
    ok(shifted <= SHIFTS_MAX and at == 0, "which leads to its result, and moves nothing under a hand", (at, movers))
    browser.script("location.hash = '#/jobs/0193b5f2-7c1e-7f7a-9d3e-2a6c1f0b8e11'")
    shows(browser, "trouble", "there is no job 0193b5f2")
    equal((browser.element("watch").is_displayed(), browser.element("canvas").get_attribute("aria-label")), (False, "No cloud yet"),
          "of a job that is none nothing is shown, and nothing of the one before")


def keys(browser):
    path = os.path.abspath(f"{PICTURES}/keys")
    os.makedirs(PICTURES, exist_ok=True)
    with open(path, "w", encoding="utf-8") as out:
        out.write(f"somebody:submit,read:{hashlib.sha256(KEY.encode()).hexdigest()}\n")
    daemon = Daemon("--api-keys", path)
    browser.open(daemon.url)
    wait("a field for the key", lambda: browser.element("key").is_displayed())
    shows(browser, "trouble", "This daemon needs an API key")
    browser.element("key").send_keys(KEY + "\n")
    wait("the form", lambda: browser.driver.find_elements(By.ID, "ask-points"))
    ok(not browser.element("key").is_displayed() and browser.element("forget").is_displayed(), "where a key is wanted, a field takes it, and it can be forgotten")
    equal(browser.script("return document.activeElement.id"), "file", "then the file is next")
    drop(browser, torus(500), "mine.ply")
    shows(browser, "cloud-words", "500 points")
    ask(browser, points=200)
    run_to_end(browser)
    browser.script("document.getElementById('commands').open = true")
    for language, wanted in (("curl", "$VORONOID_KEY"), ("js", "process.env.VORONOID_KEY"), ("python", 'os.environ["VORONOID_KEY"]')):
        browser.driver.find_element(By.CSS_SELECTOR, f"[data-language={language}]").click()
        wait("the command", lambda: wanted in browser.text("command"))
        ok(KEY not in browser.text("command"), f"the command for {language} names the variable, and not the key")
    browser.driver.refresh()
    with claim("the key is kept for the session"):
        finished(browser)
    return daemon


def crowded(browser):
    """A daemon that has as many streams as it may, and whose one place is taken."""
    daemon = Daemon("--jobs", "1", "--threads", "1", "--streams", "1")
    def ask_for(path, body=None, method=None, **headers):
        return urllib.request.urlopen(urllib.request.Request(daemon.url + path, body, headers, method=method))
    submit = lambda name: json.load(ask_for(f"/v1/resample?points=6000&iterations=12&polish=10000&name={name}", torus(6000), Prefer="respond-async"))["jobID"]
    first, second = submit("first.ply"), submit("second.ply")
    with ask_for(f"/v1/jobs/{first}/events") as stream:
        stream.readline()
        browser.open(daemon.url)
        drop(browser, torus(500), "third.ply")
        shows(browser, "cloud-words", "500 points")
        ask(browser, points=200)
        browser.element("run").click()
        with claim("a job that waits says how many are before it, and hears of those who leave"):
            shows(browser, "state", "1 ahead in the queue")
            browser.picture(f"{PICTURES}/queued.png")
            ask_for(f"/v1/jobs/{second}", method="DELETE").close()
            shows(browser, "state", "next in the queue")
        browser.script("location.hash = `#/jobs/${arguments[0]}`", first)
        before = wait("a curve", lambda: charted(browser) >= 5 and charted(browser))
        wait("the curve grows", lambda: charted(browser) > before)
        ok(stream.status == 200, "where no stream is left the curve grows all the same")
        browser.element("stop").click()
        finished(browser)
        ok("you stopped it early" in browser.text("summary"), "to the end", browser.text("summary"))
    return daemon


def preferred(browser):
    """What the requests for events since the last look have preferred."""
    at = len(browser.polls)
    browser.listen()
    return {prefer for _, prefer in browser.polls[at:]}


def unseen(browser):
    """A tab without SharedWorker that nobody looks at: it keeps none of the six connections."""
    look = lambda hidden: browser.script("""
        Object.defineProperty(document, 'hidden', { configurable: true, get: () => arguments[0] });
        document.dispatchEvent(new Event('visibilitychange'));""".replace("arguments[0]", str(hidden).lower()))
    long_job(browser)
    look(True)
    preferred(browser)
    before = charted(browser)
    wait("the curve grows", lambda: charted(browser) > before)
    with claim("a tab that nobody sees asks now and then, and waits for news once it is seen"):
        wait("a question", lambda: len(browser.polls) and preferred(browser) == {"wait=0"})
        look(False)
        wait("one that waits", lambda: "wait=10" in preferred(browser))
    line(browser, True)
    with claim("a daemon that answers no more is said to, until it does again"):
        shows(browser, "figures", "The daemon does not answer.")
        line(browser, False)
        shows(browser, "figures", "Polish step")
    browser.element("dismiss").click()
    shows(browser, "state", "Cancelled")


FORBIDDEN = """
delete window.SharedWorker;
for (const name of ['localStorage', 'sessionStorage'])
    Object.defineProperty(window, name, { get() { throw new DOMException(name, 'SecurityError'); } });
"""


def without_webgl(daemon):
    """A browser that draws nothing and so is quick with many tabs; then one that has no SharedWorker and remembers nothing as well."""
    browser = Browser(webgl=False)
    browser.open(daemon.url)
    wait("words about it", lambda: "WebGL" in browser.text("no-webgl"))
    eight_tabs(browser)
    forbid = lambda: browser.driver.execute_cdp_cmd("Page.addScriptToEvaluateOnNewDocument", {"source": FORBIDDEN})
    forbid()
    browser.open(daemon.url + "/?")
    browser.polls.clear()
    wait("the form", lambda: browser.driver.find_elements(By.ID, "ask-points"))
    browser.element("theme").click()
    equal(browser.script("return document.documentElement.dataset.theme"), "dark", "a browser that may remember nothing has the page all the same")
    drop(browser, torus(500), "blind.ply")
    shows(browser, "cloud-words", "500 points")
    ask(browser, points=200)
    browser.element("run").click()
    with claim("without WebGL the page says so, and jobs run all the same"):
        shows(browser, "state", "Done")
        wait("a summary", lambda: "200 points" in browser.text("summary"))
    wait("the whole curve", lambda: charted(browser) >= 5)
    alone = browser.script("return typeof SharedWorker === 'undefined'")
    ok(alone and preferred(browser) == {"wait=10"}, "without SharedWorker it waits for news of a job by long polls", browser.polls)
    unseen(browser)
    eight_tabs(browser, forbid)
    asked = {prefer for _, prefer in browser.polls}
    ok(asked and asked <= {"wait=0", "wait=1", "wait=10"}, "by polls alone where there is no SharedWorker", asked)
    return browser


def small(daemon):
    def fetch(path):
        request = urllib.request.Request(daemon.url + path, headers={"Accept": "text/html, */*", "Accept-Encoding": "gzip"})
        with urllib.request.urlopen(request) as answer:
            return answer.read()

    page = fetch("/")
    names = set(re.findall(r'"assets/([\w.]+)"', gzip.decompress(page).decode()))
    names |= set(re.findall(r'"(\w+\.js)"', gzip.decompress(fetch("/assets/page.js")).decode()))  # its workers
    size = len(page) + sum(len(fetch(f"/assets/{name}")) for name in names)
    equal(sorted(names), ["cloud_worker.js", "icon.svg", "page.css", "page.js", "stream.js"], "the page has these files")
    ok(100_000 < size <= PAGE_BYTES_MAX, "the page is 250 KB gzipped at most", size)


def clean(browsers, daemons):
    errors = [one for browser in browsers for one in browser.errors if "Failed to load resource" not in one]
    equal(errors, [], "the console has no error")
    foreign = [url for browser in browsers for url in browser.requests if not url.startswith((*(one.url for one in daemons), "blob:"))]
    equal(foreign, [], "no request goes elsewhere")


def main():
    daemons = [Daemon("--jobs", "2", "--threads", "1")]
    browsers = [Browser()]
    browser = browsers[0]
    try:
        browser.open(daemons[0].url)
        small(daemons[0])
        first_look(browser)
        drop_to_result(browser)
        compare(browser)
        take_away(browser)
        unanswered(browser)
        reachable(browser)
        form(browser)
        appearance(browser)
        reload_and_stop(browser)
        cancelled_upload(browser)
        bad_files(browser)
        failed_job(browser)
        surface(browser)
        other_format(browser, daemons[0])
        reference(browser, daemons[0])
        history(browser)
        daemons.append(keys(browser))
        daemons.append(crowded(browser))
        many_points(browser, daemons[-1].folder.name)
        browser.listen()
        documentation(browser, daemons[0].url)
        browser.open("about:blank")  # so that nobody measures so many points any more
        browsers.append(without_webgl(daemons[0]))
        clean(browsers, daemons)
    except Abandoned:
        print("# what comes after it was left out", flush=True)
    except Exception:
        ok(False, "everything that the claims need comes about", traceback.format_exc())
    for one in browsers:
        one.close()
    codes = [one.stop() for one in daemons]
    equal(codes, [0] * len(daemons), "the daemons end with 0")
    if os.environ.get("VT_SOAK") and not ok.failed:
        pictures.main(PICTURES, [one for one in CLOUDS if os.path.exists(one)])
    print(f"1..{ok.count}")
    sys.exit(1 if ok.failed else 0)


main()
