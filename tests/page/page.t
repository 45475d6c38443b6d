#!/usr/bin/python3
"""The page in a browser before the daemon: what a person does with it, and that nothing goes wrong meanwhile. Pictures of what was
seen are in build/page."""
import base64
import gzip
import hashlib
import os
import re
import sys
import urllib.request

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from browser import Browser, By, Daemon, wait  # noqa: E402
from made import FAR, torus  # noqa: E402

PICTURES = "build/page"
PAGE_BYTES_MAX = 250_000
KEY = "a key of somebody's"
FOCUSABLE = "a[href], button, input, select, summary, canvas[tabindex], pre[tabindex]"
done = 0


def ok(is_true, sentence, why=""):
    global done
    done += 1
    print(f"{'ok' if is_true else 'not ok'} {done} - {sentence}", flush=True)
    if not is_true:
        print(f"# {why}", flush=True)
        ok.failed = True


def equal(got, wanted, sentence):
    ok(got == wanted, sentence, f"got {got!r}, want {wanted!r}")


ok.failed = False


def shows(browser, name, words):
    return wait(f"{name} says {words!r}, and not {browser.text(name)!r}", lambda: words in browser.text(name))


def drop(browser, cloud, name):
    browser.drop(base64.b64encode(cloud).decode(), name)


def ask(browser, **values):
    """Fills the form; parameters that are folded away are unfolded first, as a person would."""
    wait("the form is there", lambda: browser.driver.find_elements(By.ID, "ask-points"))
    browser.script("document.querySelectorAll('#fields details').forEach((one) => { one.open = true; })")
    for name, value in values.items():
        field = browser.element(f"ask-{name}")
        field.clear()
        field.send_keys(str(value))
    browser.script("document.querySelectorAll('#fields details').forEach((one) => { one.open = false; })")


def charted(browser):
    return int(browser.element("chart").get_attribute("data-points") or 0)


def drawn(browser):
    return int(browser.element("canvas").get_attribute("data-drawn") or 0)


def finished(browser):
    shows(browser, "state", "Done")
    wait("a summary", lambda: "δ" in browser.text("summary"))
    wait("the result is there to compare", lambda: browser.element("layouts").is_displayed())


def drop_to_result(browser):
    drop(browser, torus(4000, FAR), "far away's torus.ply")
    shows(browser, "cloud-words", "4,000 points")
    wait("the cloud is drawn", lambda: drawn(browser) == 4000)
    browser.listen()
    posts = [url for url in browser.requests if "name=" in url]
    equal(posts, [], "a cloud is shown before any of it is sent")
    ask(browser, points=1000)
    browser.element("run").click()
    finished(browser)
    ok(wait("the chart", lambda: charted(browser) >= 5), "the chart of a short job has five points or more")
    ok("4,000 → 1,000 points" in browser.text("summary"), "the summary has the points that came and went", browser.text("summary"))
    wait("both are drawn", lambda: drawn(browser) in (4000, 1000, 5000))
    browser.picture(f"{PICTURES}/result.png")


def compare(browser):
    shown = lambda: browser.script("return document.querySelector('input[name=layout]:checked').value")
    equal(shown(), "both", "input and result stand side by side")
    browser.element("canvas").send_keys(" ")
    first = shown()
    browser.element("canvas").send_keys(" ")
    equal({first, shown()}, {"input", "result"}, "the space bar changes between them")
    for mode in ("distance", "spacing"):
        browser.script("const m = document.getElementById('mode'); m.value = arguments[0]; m.dispatchEvent(new Event('change'));", mode)
        wait("a histogram", lambda: browser.element("histogram").is_displayed())
        shows(browser, "histogram-caption", "over its mean" if mode == "spacing" else "point of the input")
        text = browser.text("histogram-caption")
        ok("1,000 points" in text or "4,000 points" in text, f"coloured by {mode}, a histogram says of how many points it is", text)
    browser.script("const m = document.getElementById('mode'); m.value = 'distance'; m.dispatchEvent(new Event('change'));")
    shows(browser, "histogram-caption", "point of the input")
    most = float(re.search(r"from 0 to ([\d.e-]+)", browser.text("histogram-caption"))[1])
    ok(0 < most < 0.2, "far from zero the result lies on the input, in doubles: float32 has steps of 0.5 there", most)


def take_away(browser):
    browser.script("document.getElementById('commands').open = true")
    browser.driver.find_element(By.CSS_SELECTOR, "[data-language=curl]").click()
    wait("a command", lambda: browser.element("command").is_displayed())
    text = browser.text("command")
    ok("'@far away'\\''s torus.ply'" in text and "points=1000" in text, "a command has the file's name as a shell wants it", text)
    browser.script("document.getElementById('commands').open = false")
    names = browser.script("""
        const names = [];
        HTMLAnchorElement.prototype.click = function () { names.push(this.download); };
        window.names = names;
        return [...document.querySelectorAll('#takers button')].map((one) => one.textContent);""")
    equal(names[:2], ["PLY", "Draco"], "the result can be had as PLY and as Draco")
    for button in browser.driver.find_elements(By.CSS_SELECTOR, "#takers button") + [browser.element("png")]:
        button.click()
    saved = wait("all files are saved", lambda: len(browser.script("return window.names")) == len(names) + 1 and browser.script("return window.names"))
    equal(sorted(saved), sorted(f"far away's torus.{end}" for end in ("resample.ply", "resample.drc", "report.json", "metrics.csv", "png")),
          "files are named after the input")


def reached(browser):
    """The ids (or words) of what the tab key leads to, once around."""
    browser.script("document.activeElement.blur(); window.reached = new Set();"
                   "document.addEventListener('focusin', (event) => window.reached.add(event.target));")
    for _ in range(30):
        before = browser.script("return window.reached.size")
        browser.tab(10)
        if browser.script("return window.reached.size") == before:
            break


def reachable(browser):
    browser.script("document.querySelectorAll('details').forEach((one) => { one.open = true; })")
    reached(browser)
    missed = browser.script(f"""
        const groups = new Set([...window.reached].filter((one) => one.type === 'radio').map((one) => one.name));
        return [...document.querySelectorAll('{FOCUSABLE}')].filter((one) => one.checkVisibility() && !one.disabled
            && !window.reached.has(one) && !groups.has(one.name || '')).map((one) => one.outerHTML.slice(0, 90));""")
    equal(missed, [], "the tab key leads to every control")
    elements = [one for one in browser.driver.find_elements(By.CSS_SELECTOR, FOCUSABLE) if one.is_displayed()]
    unnamed = browser.script("""
        return arguments[0].filter((one) => !(one.labels?.length || one.getAttribute('aria-label') || one.getAttribute('aria-labelledby')
            || one.textContent.trim())).map((one) => one.outerHTML.slice(0, 90));""", elements)
    equal(unnamed, [], "every control has a label")
    ok(len(elements) > 40, "with all that is folded away, there are many of them", len(elements))
    browser.script("document.querySelectorAll('details').forEach((one) => { one.open = false; })")


def long_job(browser, name="long.ply"):
    """A job that goes on until somebody ends it."""
    drop(browser, torus(6000), name)
    shows(browser, "cloud-words", f"{name}: 6,000 points")
    ask(browser, points=6000, polish=10000, iterations=12)
    browser.element("run").click()
    wait("a curve", lambda: charted(browser) >= 5)
    return browser.driver.current_url


def reload_and_stop(browser):
    url = long_job(browser)
    ok("#/jobs/" in url, "the address names the job", url)
    browser.driver.refresh()
    wait("the curve again", lambda: charted(browser) >= 5)
    label = browser.element("chart").get_attribute("aria-label")
    shows(browser, "cloud-words", "6,000 points")
    ok(True, "reloaded in the middle of a job, the page has its input again")
    job = url.split("/")[-1]
    table = browser.script("return fetch('v1/jobs/' + arguments[0] + '/trace').then((one) => one.json())", job)
    first = float(f"{table['records'][0]['delta']:.4g}")
    ok(f"delta from {first:g} " in label.replace(",", ""), "and the curve from its first record on", (first, label))
    wait("it can be stopped", lambda: browser.element("stop").is_displayed())
    wait("the points as they move", lambda: browser.element("layouts").is_displayed())
    ok(browser.text("summary") == "", "while a job runs its points are shown as they move")
    browser.picture(f"{PICTURES}/running.png")
    browser.element("stop").click()
    finished(browser)
    ok("stopped by its caller" in browser.text("summary"),
       "a job that is stopped has a result, which says so", browser.text("summary"))
    table = browser.script("return fetch('v1/jobs/' + arguments[0] + '/trace').then((one) => one.json())", job)
    wait("the last record", lambda: charted(browser) >= len(table["records"]))
    equal(charted(browser), len(table["records"]), "the chart has every record of the trace, each once")


def eight_tabs(browser):
    first, home = browser.driver.current_window_handle, browser.driver.current_url.split("#")[0]
    for _ in range(7):
        browser.driver.switch_to.new_window("tab")
        browser.open(home)
    browser.driver.switch_to.window(first)
    url = long_job(browser, "tabs.ply")  # now, so that it does not compute while tabs are opened
    handles = browser.driver.window_handles
    for handle in handles:
        browser.driver.switch_to.window(handle)
        browser.script("location.href = arguments[0]", url)
    for handle in handles:
        browser.driver.switch_to.window(handle)
        wait("each tab has a curve", lambda: charted(browser) >= 5)
    ok(len(handles) == 8, "eight tabs on one job all have its curve")
    before = charted(browser)
    wait("the curve of the last one grows", lambda: charted(browser) > before)
    browser.element("dismiss").click()
    for handle in handles:
        browser.driver.switch_to.window(handle)
        shows(browser, "state", "Cancelled")
        if handle != first:
            browser.listen()
            browser.driver.close()
    browser.driver.switch_to.window(first)
    ok(True, "and all hear that one of them cancelled it")


def bad_files(browser):
    drop(browser, b"hello there, this is no cloud", "letter.txt")
    shows(browser, "trouble", 'the input begins with "hello there')
    ok(True, "of a file that is no cloud the daemon's words are shown")
    drop(browser, torus(100)[:-40], "short.ply")
    shows(browser, "trouble", "ends before its last row")
    browser.element("run").click()
    shows(browser, "trouble", "vertex")
    ok(True, "a file that ends early is refused, in the page's words and then in the daemon's", browser.text("trouble"))
    drop(browser, torus(500), "small.ply")
    shows(browser, "cloud-words", "500 points")
    equal(browser.text("trouble"), "", "another file takes the words away")
    ask(browser, points=0)
    browser.element("run").click()
    ok(not browser.element("ask-points").get_property("validity")["valid"], "a number out of range stays on the page")


def other_format(browser, daemon):
    request = urllib.request.Request(f"{daemon.url}/v1/convert?format=drc", torus(800))
    with urllib.request.urlopen(request) as answer:
        drop(browser, answer.read(), "packed.drc")
    shows(browser, "cloud-words", "packed.drc: 800 points")
    ask(browser, points=300)
    browser.element("run").click()
    finished(browser)
    ok("800 → 300 points" in browser.text("summary"), "a Draco file is shown, and run without sending it again", browser.text("summary"))


def appearance(browser):
    equal(browser.script("return document.documentElement.dataset.theme"), "light", "the page is light where the system is")
    browser.element("theme").click()
    equal(browser.script("return document.documentElement.dataset.theme"), "dark", "and dark when asked to be")
    browser.picture(f"{PICTURES}/dark.png")
    browser.driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", {"width": 390, "height": 844, "deviceScaleFactor": 1, "mobile": True})
    wide = browser.script("return document.documentElement.scrollWidth")
    ok(wide <= 390, "on a phone nothing is wider than the screen", wide)
    browser.picture(f"{PICTURES}/phone.png")
    browser.driver.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})


def history(browser):
    listed = lambda: browser.script("return [...document.querySelectorAll('#history li')].map((one) => one.textContent)")
    rows = wait("the list of jobs", lambda: any("packed.drc: resample" in row for row in listed()) and listed())
    ok(any("small.ply" in row or "tabs.ply: resample" in row for row in rows), "the jobs of the daemon are listed", rows)
    last = browser.script("const all = document.querySelectorAll('#history a'); all[all.length - 1].click(); return all[all.length - 1].hash")
    wait("another job", lambda: browser.driver.current_url.endswith(last))
    finished(browser)
    ok(True, "and one can be opened again")


def keys(browser):
    path = os.path.abspath(f"{PICTURES}/keys")
    os.makedirs(PICTURES, exist_ok=True)
    with open(path, "w", encoding="utf-8") as out:
        out.write(f"somebody:submit,read:{hashlib.sha256(KEY.encode()).hexdigest()}\n")
    daemon = Daemon("--api-keys", path)
    browser.open(daemon.url)
    wait("a field for the key", lambda: browser.element("key").is_displayed())
    browser.element("key").send_keys(KEY + "\n")
    wait("the form", lambda: browser.driver.find_elements(By.ID, "ask-points"))
    ok(not browser.element("key").is_displayed(), "where a key is wanted, a field takes it")
    drop(browser, torus(500), "mine.ply")
    shows(browser, "cloud-words", "500 points")
    ask(browser, points=200)
    browser.element("run").click()
    finished(browser)
    browser.script("document.getElementById('commands').open = true")
    for language, wanted in (("curl", "$VORONOID_KEY"), ("js", "process.env.VORONOID_KEY"), ("python", 'os.environ["VORONOID_KEY"]')):
        browser.driver.find_element(By.CSS_SELECTOR, f"[data-language={language}]").click()
        wait("the command", lambda: wanted in browser.text("command"))
        ok(KEY not in browser.text("command"), f"the command for {language} names the variable, and not the key")
    browser.driver.refresh()
    finished(browser)
    ok(True, "the key is kept for the session")
    return daemon


def without_webgl(daemon):
    browser = Browser(webgl=False)
    browser.open(daemon.url)
    wait("words about it", lambda: "WebGL" in browser.text("no-webgl"))
    drop(browser, torus(500), "blind.ply")
    ask(browser, points=200)
    browser.element("run").click()
    shows(browser, "state", "Done")
    wait("a summary", lambda: "200 points" in browser.text("summary"))
    ok(True, "without WebGL the page says so, and jobs run all the same")
    browser.listen()
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
        drop_to_result(browser)
        compare(browser)
        take_away(browser)
        reachable(browser)
        appearance(browser)
        reload_and_stop(browser)
        eight_tabs(browser)
        bad_files(browser)
        other_format(browser, daemons[0])
        history(browser)
        daemons.append(keys(browser))
        browser.listen()
        browsers.append(without_webgl(daemons[0]))
        clean(browsers, daemons)
    finally:
        for one in browsers:
            one.close()
        codes = [one.stop() for one in daemons]
    equal(codes, [0, 0], "the daemons end with 0")
    print(f"1..{done}")
    sys.exit(1 if ok.failed else 0)


main()
