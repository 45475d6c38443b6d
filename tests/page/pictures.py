#!/usr/bin/python3
"""usage: pictures.py OUT CLOUD...: pictures of each state of the page on clouds, light, dark and as wide as a phone."""
import os
import sys

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from browser import Browser, By, Daemon, wait  # noqa: E402

SIZES = {"light": (1280, 860), "dark": (1280, 860), "phone": (390, 844)}
POINTS = 8000


def choose(browser, name, value):
    browser.script("const one = document.getElementById(arguments[0]); one.value = arguments[1]; one.dispatchEvent(new Event('change'));", name, value)


def layout(browser, value):
    browser.script("document.querySelector(`input[name=layout][value=${arguments[0]}]`).click()", value)


def measured(browser):
    wait("a histogram", lambda: browser.element("histogram").is_displayed())


def states(browser, path, picture):
    """Goes through what a person sees of one cloud: picture(state) after each."""
    name = os.path.basename(path)
    browser.choose(path)
    wait("the cloud", lambda: f"{name}: " in browser.text("cloud-words") and "points" in browser.text("cloud-words"))
    picture("dropped")
    wait("the form", lambda: browser.driver.find_elements(By.ID, "ask-points"))
    field = browser.element("ask-points")
    field.clear()
    field.send_keys(str(POINTS))
    browser.script("document.getElementById('run').click()")
    wait("a curve", lambda: int(browser.element("chart").get_attribute("data-points") or 0) >= 5)
    browser.script("document.getElementById('watch').scrollIntoView()")
    picture("running")
    wait("the result", lambda: browser.element("layouts").is_displayed() and browser.text("summary"))
    browser.script("document.body.scrollIntoView()")
    layout(browser, "both")
    picture("both")
    choose(browser, "mode", "spacing")
    measured(browser)
    picture("spacing")
    layout(browser, "swipe")
    choose(browser, "mode", "normals")
    picture("swipe")
    layout(browser, "result")
    choose(browser, "mode", "distance")
    measured(browser)
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
                if theme == "dark":
                    browser.element("theme").click()
                for path in clouds:
                    name = os.path.splitext(os.path.basename(path))[0]
                    states(browser, path, lambda state: (wait_a_frame(browser), browser.picture(f"{out}/{name}-{state}-{theme}.png")))
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
