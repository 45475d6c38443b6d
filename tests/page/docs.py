"""The documentation in a browser: the topics of the help, and the contract that a script renders."""
import json
import urllib.request

from browser import wait
from claims import equal, ok


def documentation(browser, url):
    browser.open(f"{url}/docs")
    contract = json.load(urllib.request.urlopen(f"{url}/openapi.json"))
    wait("the contract is rendered", lambda: browser.script("return document.querySelector('#contract h3') !== null"))
    shown = browser.script("return [...document.querySelectorAll('#contract summary code')].map((one) => one.textContent)")
    operations = [f"{method.upper()} {path}" for path, one in contract["paths"].items() for method in one if method in ("get", "post", "delete")]
    equal(shown, operations + list(contract["components"]["schemas"]), "the documentation has every operation and schema of the contract")
    ok(browser.script("return document.documentElement.scrollWidth <= innerWidth"), "and scrolls in one direction alone")
