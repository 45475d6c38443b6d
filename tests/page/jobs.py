"""Jobs as a person follows them: without a daemon, reloaded, stopped, in eight tabs, cancelled while they are sent, failed."""
from browser import By, wait
from claims import PICTURES, ask, charted, claim, compared, drop, equal, filled, finished, ok, shows
from made import torus


def line(browser, offline):
    browser.driver.execute_cdp_cmd("Network.emulateNetworkConditions", {
        "offline": offline, "latency": 0, "downloadThroughput": -1, "uploadThroughput": -1})


def unanswered(browser):
    """A daemon that cannot be reached."""
    line(browser, True)
    browser.element("run").click()
    with claim("a daemon that does not answer is said to"):
        shows(browser, "trouble", "The daemon does not answer.")
    line(browser, False)


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
    with claim("reloaded in the middle of a job, the page has its curve and its input again"):
        wait("the curve again", lambda: charted(browser) >= 5)
        label = browser.element("chart").get_attribute("aria-label")
        shows(browser, "cloud-words", "6,000 points")
    filled(browser, points=6000, polish=10000, iterations=12)
    job = url.split("/")[-1]
    table = browser.script("return fetch('v1/jobs/' + arguments[0] + '/trace').then((one) => one.json())", job)
    first = float(f"{table['records'][0]['delta']:.3g}")
    ok(f"δ from {first:g} " in label.replace(",", ""), "and the curve from its first record on", (first, label))
    wait("it can be stopped", lambda: browser.element("stop").is_displayed())
    wait("the points as they move", lambda: compared(browser))
    ok(browser.text("summary") == "", "while a job runs its points are shown as they move")
    browser.picture(f"{PICTURES}/running.png")
    browser.element("stop").click()
    finished(browser)
    ok("you stopped it early" in browser.text("summary"),
       "a job that is stopped has a result, which says so", browser.text("summary"))
    table = browser.script("return fetch('v1/jobs/' + arguments[0] + '/trace').then((one) => one.json())", job)
    wait("the last record", lambda: charted(browser) >= len(table["records"]))
    equal(charted(browser), len(table["records"]), "the chart has every record of the trace, each once")
    ask(browser, iterations=2, polish=10)  # for the jobs that follow


def eight_tabs(browser, made=lambda: None):
    """As many tabs as would wait for each other with a connection each, opened unless they are there. made() is called for each but
    the first, before the page is there."""
    first, home = browser.driver.current_window_handle, browser.driver.current_url.split("#")[0]
    for _ in range(8 - len(browser.driver.window_handles)):
        browser.driver.switch_to.new_window("tab")
    for handle in browser.driver.window_handles:
        if handle != first:
            browser.driver.switch_to.window(handle)
            made()
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
    with claim("and all hear that one of them cancelled it"):
        for handle in handles:
            browser.driver.switch_to.window(handle)
            shows(browser, "state", "Cancelled")
            browser.listen()
    browser.driver.switch_to.window(first)


def cancelled_upload(browser):
    """Over a slow line."""
    line = lambda rate: browser.driver.execute_cdp_cmd("Network.emulateNetworkConditions", {
        "offline": False, "latency": 0, "downloadThroughput": -1, "uploadThroughput": rate})
    drop(browser, torus(40_000), "slow.ply")
    shows(browser, "cloud-words", "40,000 points")
    line(1_000)  # it would take 18 minutes
    browser.element("run").click()
    shows(browser, "upload-words", " of 1.08 MB")
    browser.picture(f"{PICTURES}/upload.png")
    browser.element("upload-cancel").click()
    shows(browser, "trouble", "The upload was cancelled.")
    line(-1)
    jobs = browser.script("return fetch('v1/jobs').then((one) => one.json())")["jobs"]
    ok(not browser.element("upload").is_displayed() and all(job["voronoid"].get("name") != "slow.ply" for job in jobs),
       "an upload that is cancelled leaves no job behind", jobs)


def failed_job(browser):
    head = b"ply\nformat ascii 1.0\nelement vertex 9\n" + b"".join(b"property float %c\n" % axis for axis in b"xyz") + b"end_header\n"
    drop(browser, head + b"1 1 1\n" * 9, "one place.ply")
    shows(browser, "cloud-words", "9 points")
    ask(browser, points=5)
    browser.element("run").click()
    shows(browser, "state", "Failed")
    shows(browser, "trouble", "the cloud has 1 distinct points, want at least 4")
    ok(not browser.driver.find_elements(By.CSS_SELECTOR, "#takers button"), "a job that fails says why, and has nothing to take")
    browser.picture(f"{PICTURES}/failed.png")
