#!/usr/bin/python3
"""usage: pictures.py OUT CLOUD...: pictures of each state of the page on clouds, light, dark and as wide as a phone."""
import os
import sys

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from browser import Browser, By, Daemon, wait  # noqa: E402
from claims import compared  # noqa: E402

SIZES = {"light": (1280, 860), "dark": (1280, 860), "phone": (390, 844)}
POINTS = 8000


def choose(browser, name, value):
    browser.script("const one = document.getElementById(arguments[0]); one.value = arguments[1]; one.dispatchEvent(new Event('change'));", name, value)


def dropped(browser, path):
    name = os.path.basename(path)
    browser.choose(path)
    wait("the cloud", lambda: f"{name}: " in browser.text("cloud-words") and "points" in browser.text("cloud-words"))
    browser.script("scrollTo(0, 0)")


def ask(browser, process, **values):
    """Fills the form of a process; what is not named keeps its default."""
    wait("the form", lambda: browser.driver.find_elements(By.CSS_SELECTOR, "#process option"))
    choose(browser, "process", process)
    browser.script("""
        document.querySelectorAll('#fields input:not([type=checkbox]), #fields select').forEach((one) => { one.value = arguments[0][one.id.slice(4)] || ''; });
        document.querySelector('#fields').firstElementChild.dispatchEvent(new Event('input', { bubbles: true }));""", {name: str(value) for name, value in values.items()})


def run(browser):
    before = browser.driver.current_url
    browser.script("document.getElementById('run').click()")
    wait("a job", lambda: browser.driver.current_url != before or browser.text("trouble"))


def states(browser, path, picture):
    """Goes through what a person sees of one cloud: picture(state) after each."""
    dropped(browser, path)
    picture("dropped")
    ask(browser, "resample", points=POINTS, polish=10000, iterations=40)
    run(browser)
    wait("a curve", lambda: int(browser.element("chart").get_attribute("data-points") or 0) >= 5)
    wait("the points as they move", lambda: compared(browser))
    browser.script("document.getElementById('watch').scrollIntoView()")
    picture("running", rests=False)
    browser.element("stop").click()
    wait("its end", lambda: browser.text("summary"))
    ask(browser, "resample", points=POINTS)
    run(browser)
    wait("the result", lambda: compared(browser) and browser.text("summary"))
    browser.script("document.body.scrollIntoView()")
    picture("both")
    choose(browser, "style", "discs")
    picture("discs")
    choose(browser, "mode", "distance")
    picture("distance")
    browser.script("const one = document.getElementById('report-box'); one.open = true; one.scrollIntoView();")
    picture("report")


def main(out, clouds):
    daemon = Daemon()
    try:
        for theme, size in SIZES.items():
            browser = Browser(size)
            try:
                browser.open(daemon.url)
                wait("the form", lambda: browser.driver.find_elements(By.CSS_SELECTOR, "#process option"))
                if theme == "dark":
                    browser.element("theme").click()
                browser.picture(f"{out}/empty-{theme}.png")
                for path in clouds:
                    name = os.path.splitext(os.path.basename(path))[0]
                    picture = lambda state, rests=True: (rests and wait_a_frame(browser), browser.picture(f"{out}/{name}-{state}-{theme}.png"))
                    states(browser, path, picture)
            finally:
                browser.close()
    finally:
        daemon.stop()


def wait_a_frame(browser):
    """Until normals and the points of a view at rest are drawn."""
    seen = None
    while seen != (now := browser.element("canvas").get_attribute("data-frames")):
        seen = now
        browser.driver.execute_async_script("setTimeout(arguments[0], 400)")


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2:])
