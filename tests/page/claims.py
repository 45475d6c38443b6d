"""What the page's tests say and wait for: claims as TAP, the form filled, a job's curve and result."""
import base64
import contextlib
import re
import sys
import traceback

from browser import By, wait

PICTURES = "build/page"


def ok(is_true, sentence, why=""):
    ok.count += 1
    print(f"{'ok' if is_true else 'not ok'} {ok.count} - {sentence}", flush=True)
    if not is_true:
        print("\n".join(f"# {row}" for row in str(why).splitlines()), file=sys.stderr, flush=True)
        ok.failed = True


def equal(got, wanted, sentence):
    ok(got == wanted, sentence, f"got {got!r}, want {wanted!r}")


ok.count, ok.failed = 0, False


class Abandoned(Exception):
    """A claim that others hang on does not hold, and was told."""


@contextlib.contextmanager
def claim(sentence):
    """Holds once all that is waited for within it has come."""
    try:
        yield
    except Exception as why:
        ok(False, sentence, traceback.format_exc())
        raise Abandoned from why
    ok(True, sentence)


def shows(browser, name, words):
    return wait(f"{name} says {words!r}, and not {browser.text(name)!r}", lambda: words in browser.text(name))


def drop(browser, cloud, name):
    browser.drop(base64.b64encode(cloud).decode(), name)


def ask(browser, **values):
    """Fills the form; parameters that are folded away are unfolded first, as a person would."""
    wait("the form is there", lambda: browser.driver.find_elements(By.ID, "ask-points"))
    fold = lambda isOpen: browser.script("arguments[0].forEach((name) => { const one = document.getElementById(`ask-${name}`).closest('details');"
                                         "if (one) one.open = arguments[1]; })", list(values), isOpen)
    fold(True)
    for name, value in values.items():
        field = browser.element(f"ask-{name}")
        field.clear()
        field.send_keys(str(value))
    fold(False)


def charted(browser):
    return int(browser.element("chart").get_attribute("data-points") or 0)


def drawn(browser):
    return int(browser.element("canvas").get_attribute("data-drawn") or 0)


def compared(browser):
    return not browser.element("layouts").get_property("disabled")


def deltas(browser):
    """What the page says of the result's delta: in its headline, below the view, at the end of the chart."""
    places = [("summary", r"δ\s([\d.e-]+)"), ("caption-result", r"δ\s([\d.e-]+)")]
    said = [float((re.search(pattern, browser.text(name)) or [0, "nan"])[1]) for name, pattern in places]
    return said + [float(browser.element("chart").get_attribute("aria-label").rsplit(" ", 1)[1])]


def run_to_end(browser):
    """Presses Run. The page still shows the end of the job before until the daemon has taken the new one."""
    before = browser.driver.current_url
    browser.element("run").click()
    wait("the page of a new job", lambda: browser.driver.current_url != before)
    finished(browser)


def finished(browser):
    shows(browser, "state", "Done")
    wait("a summary", lambda: "δ" in browser.text("summary"))
    wait("the result is there to compare", lambda: compared(browser))


def filled(browser, **wanted):
    got = browser.script("return arguments[0].map((name) => document.getElementById(`ask-${name}`)?.value)", list(wanted))
    equal(got, [str(value) for value in wanted.values()], "opened again, a job fills the form with what it was asked for")
