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


def result(browser):
    """What came of the job that is shown, in base64."""
    job = browser.driver.current_url.split("/")[-1]
    return browser.driver.execute_async_script("""
        const [job, done] = arguments, reader = new FileReader();
        reader.onload = () => done(reader.result.split(',')[1]);
        fetch(`v1/jobs/${job}/results/cloud?format=ply`).then((answer) => answer.blob()).then((blob) => reader.readAsDataURL(blob));""", job)


def ends(browser, path, picture):
    """How jobs end otherwise: triangles, a method of two stages, cancelled by somebody, refused, failed."""
    dropped(browser, path)
    ask(browser, "mesh", points=3000)
    run(browser)
    wait("the result", lambda: browser.element("layouts").is_displayed() and browser.text("summary"))
    browser.script("scrollTo(0, 0)")
    picture("mesh")
    browser.drop(result(browser), "a mesh.ply")
    wait("it", lambda: "a mesh.ply: " in browser.text("cloud-words") and "triangles" in browser.text("cloud-words"))
    picture("mesh-dropped")
    ask(browser, "measure")
    run(browser)
    wait("figures", lambda: browser.element("report-box").is_displayed())
    picture("measured")
    dropped(browser, path)
    ask(browser, "resample", points=16000, method="ear", samples=4000, rounds=2, steps=12)
    browser.script("document.querySelector('#fields details').open = true; document.getElementById('ask-sigmaN').scrollIntoView({ block: 'center' })")
    picture("ear-form")
    run(browser)
    wait("the insertion", lambda: browser.text("figures").startswith("Insertion") or browser.text("summary"))
    browser.script("document.getElementById('watch').scrollIntoView()")
    picture("ear-running")
    if browser.element("dismiss").is_displayed():
        browser.element("dismiss").click()
    wait("its end", lambda: browser.text("state").startswith(("Cancelled", "Done")))
    ask(browser, "resample", points=POINTS, polish=10000)
    run(browser)
    wait("a curve", lambda: int(browser.element("chart").get_attribute("data-points") or 0) >= 5)
    browser.element("dismiss").click()
    wait("its end", lambda: browser.text("state").startswith("Cancelled"))
    browser.script("scrollTo(0, 0)")
    picture("cancelled")
    ask(browser, "resample", points=POINTS, density="attribute:none")
    run(browser)
    wait("a refusal", lambda: browser.text("trouble") or browser.text("state").startswith("Failed"))
    picture("refused")


def states(browser, path, picture):
    """Goes through what a person sees of one cloud: picture(state) after each."""
    dropped(browser, path)
    picture("dropped")
    ask(browser, "resample", points=POINTS, polish=10000, iterations=40)
    run(browser)
    wait("a curve", lambda: int(browser.element("chart").get_attribute("data-points") or 0) >= 5)
    wait("the points as they move", lambda: browser.element("layouts").is_displayed())
    browser.script("document.getElementById('watch').scrollIntoView()")
    picture("running", rests=False)
    browser.element("stop").click()
    wait("its end", lambda: browser.text("summary"))
    ask(browser, "resample", points=POINTS)
    run(browser)
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
                wait("the form", lambda: browser.driver.find_elements(By.CSS_SELECTOR, "#process option"))
                if theme == "dark":
                    browser.element("theme").click()
                browser.picture(f"{out}/empty-{theme}.png")
                for path in clouds:
                    name = os.path.splitext(os.path.basename(path))[0]
                    picture = lambda state, rests=True: (rests and wait_a_frame(browser), browser.picture(f"{out}/{name}-{state}-{theme}.png"))
                    states(browser, path, picture)
                    if path == clouds[0]:
                        ends(browser, path, picture)
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
