"""A real daemon and a real browser for the tests of the page: Debian's chromium, without a screen, drawing by software."""
import json
import os
import pathlib
import signal
import subprocess
import tempfile
import time

from selenium import webdriver
from selenium.common.exceptions import TimeoutException
from selenium.webdriver.chrome.service import Service
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys

BINARY = os.environ.get("VORONOID", "build/release/voronoid")
PATIENCE = 600  # seconds that a condition is waited for: a machine may do ten other things beside it

DROP = """
const [bytes, name] = arguments, file = new File([Uint8Array.from(atob(bytes), (c) => c.charCodeAt(0))], name);
const data = new DataTransfer();
data.items.add(file);
for (const kind of ['dragenter', 'dragover', 'drop'])
    document.body.dispatchEvent(new DragEvent(kind, { bubbles: true, cancelable: true, dataTransfer: data }));
"""

SHIFTS = """
[window.shifted, window.movers] = [0, []];
new PerformanceObserver((list) => list.getEntries().filter((one) => !one.hadRecentInput).forEach((one) => {
    window.shifted += one.value;
    window.movers.push(one.value.toFixed(3), ...one.sources.map(({ node, previousRect, currentRect }) =>
        `${node?.id || node?.nodeName} ${previousRect.top} ${currentRect.top}`));
})).observe({ type: 'layout-shift', buffered: true });
"""


class Daemon:
    """voronoid serve on a free port, with a folder of its own that goes with it."""

    def __init__(self, *flags):
        self.folder = tempfile.TemporaryDirectory()
        self.log = open(os.path.join(self.folder.name, "log"), "w+", encoding="utf-8")
        self.process = subprocess.Popen([BINARY, "serve", "--listen", "127.0.0.1:0", "--data", self.folder.name + "/data", *flags],
                                        stdout=self.log, stderr=self.log)
        self.url = "http://" + wait("the daemon listens", self.address)

    def address(self):
        self.log.seek(0)
        for line in self.log:
            row = json.loads(line)
            if row["msg"] == "listening":
                return row["address"]
        return None

    def stop(self):
        self.process.send_signal(signal.SIGTERM)
        code = self.process.wait(PATIENCE)
        self.log.close()
        self.folder.cleanup()
        return code


class Browser:
    """One chromium. size: of its window; a phone's is narrower than windows may be, and is emulated."""

    def __init__(self, size=(900, 860), webgl=True):
        options = webdriver.ChromeOptions()
        drawing = ["--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"] if webgl else ["--disable-gpu", "--disable-3d-apis"]
        for flag in ["--headless=new", "--no-sandbox", "--disable-dev-shm-usage", "--no-first-run", "--disable-extensions",
                     "--disable-background-networking", "--disable-component-update", "--disable-gpu-compositing",
                     f"--window-size={size[0]},{size[1]}", *drawing]:
            options.add_argument(flag)
        options.add_experimental_option("perfLoggingPrefs", {"enableNetwork": True, "enablePage": False})
        options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
        self.driver = webdriver.Chrome(service=Service("/usr/bin/chromedriver"), options=options)
        self.driver.set_script_timeout(PATIENCE)
        self.driver.command_executor.set_timeout(PATIENCE)
        if size[0] < 500:
            self.driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride",
                                        {"width": size[0], "height": size[1], "deviceScaleFactor": 2, "mobile": True})
        self.driver.execute_cdp_cmd("Page.addScriptToEvaluateOnNewDocument", {"source": SHIFTS})
        self.errors = []
        self.requests = []
        self.polls = []  # (address, Prefer) of each request for events

    def open(self, url):
        self.driver.get(url)

    def element(self, name):
        return self.driver.find_element(By.ID, name)

    def text(self, name):
        return self.element(name).text

    def script(self, code, *arguments):
        return self.driver.execute_script(code, *arguments)

    def drop(self, base64, name):
        self.script(DROP, base64, name)

    def choose(self, path):
        self.element("file").send_keys(str(pathlib.Path(path).resolve()))

    def tab(self, times):
        ActionChains(self.driver, duration=0).send_keys(Keys.TAB * times).perform()

    def listen(self):
        """Reads what the browser has logged since: messages of errors, addresses that were asked for, and how long events were waited for."""
        self.errors += [row["message"] for row in self.driver.get_log("browser") if row["level"] == "SEVERE"]
        for row in self.driver.get_log("performance"):
            message = json.loads(row["message"])["message"]
            if message["method"] == "Network.requestWillBeSent":
                request = message["params"]["request"]
                self.requests.append(request["url"])
                if "/v1/events?" in request["url"]:
                    self.polls.append((request["url"], request["headers"].get("Prefer", "")))

    def picture(self, path):
        os.makedirs(os.path.dirname(path), exist_ok=True)
        try:
            self.driver.save_screenshot(path)
        except TimeoutException:  # the driver waits 10 s, in which a busy machine may not have drawn the page
            self.driver.save_screenshot(path)

    def close(self):
        self.driver.quit()


def wait(what, condition, patience=PATIENCE):
    """Waits until condition() is true and returns what it returned; fails with `what` otherwise."""
    end = time.monotonic() + patience
    while time.monotonic() < end:
        value = condition()
        if value:
            return value
        time.sleep(0.1)
    raise AssertionError(f"waited {patience} s in vain: {what}")
