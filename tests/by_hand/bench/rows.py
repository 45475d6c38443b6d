#!/usr/bin/python3
"""usage: rows.py VORONOID OUTDIR [ROWS]: what requests take beside ROWS (100000) jobs that ended, each with the report
of a real one and events of 30 KB, and then beside as many that wait. Writes OUTDIR/rows.md. Needs 4 GB of disk."""
import http.client, json, os, re, shutil, signal, sqlite3, struct, subprocess, sys, tempfile, threading, time, hashlib, random

binary, out, rows = sys.argv[1], sys.argv[2], int(sys.argv[3]) if len(sys.argv) > 3 else 100000
data = tempfile.mkdtemp(dir=out)
keys = os.path.join(data, "keys")
with open(keys, "w") as f:
    f.write("k:submit,read:%s:jobs=100000,rate=10000,bytes=900T\n" % hashlib.sha256(b"secret").hexdigest())
os.chmod(keys, 0o600)
random.seed(1)
ply = b"ply\nformat binary_little_endian 1.0\nelement vertex 300\nproperty float x\nproperty float y\nproperty float z\n" \
    b"end_header\n" + b"".join(struct.pack("<3f", *(random.gauss(0, 1) for _ in range(3))) for _ in range(300))
report = open(os.path.join(out, "rows.md"), "a")


def say(text):
    print(text, flush=True)
    report.write(text + "\n")
    report.flush()


class Daemon:
    def __init__(self):
        self.log = os.path.join(data, "log")
        began = time.time()
        self.process = subprocess.Popen([binary, "serve", "--listen", "127.0.0.1:0", "--data", data, "--api-keys", keys, "--jobs", "1",
            "--threads", "1", "--queue", "100000", "--queue-bytes", "100G", "--http-threads", "2", "--admin-listen", "127.0.0.1:0"], stderr=open(self.log, "w"))
        while not (found := re.search(r'"address":"127.0.0.1:(\d+)"', open(self.log).read())):
            time.sleep(0.02)
        cpu = open("/proc/%d/stat" % self.process.pid).read().split()[13:15]
        self.started = "%.2f s, %.2f s of CPU" % (time.time() - began, sum(map(int, cpu)) / os.sysconf("SC_CLK_TCK"))
        self.port = int(found.group(1))
        self.admin = int(re.search(r'"admin":"127.0.0.1:(\d+)"', open(self.log).read()).group(1))

    def connect(self):
        return http.client.HTTPConnection("127.0.0.1", self.port)

    def stop(self):
        self.process.send_signal(signal.SIGTERM)
        self.process.wait()


def ask(connection, method, path, body=None, headers={}):
    connection.request(method, path, body, {"Authorization": "Bearer secret", **headers})
    answer = connection.getresponse()
    return answer.status, answer.read()


def submit(connection, query="points=50&iterations=3"):
    status, text = ask(connection, "POST", "/v1/resample?" + query, ply, {"Prefer": "respond-async"})
    assert status == 201, text
    return json.loads(text)["jobID"]


def times(daemon, what, n=300):
    connection, took = daemon.connect(), []
    for _ in range(n):
        began = time.perf_counter()
        what(connection)
        took.append(time.perf_counter() - began)
        time.sleep(0.01)
    took.sort()
    return "%.1f / %.1f ms" % (1e3 * took[n // 2], 1e3 * took[n * 99 // 100])


def measure(daemon, label, cases):
    for name, what in cases:
        say("| %s | %s | %s |" % (label, name, times(daemon, what)))


def fill(*statements, rows=rows):
    db = sqlite3.connect(os.path.join(data, "jobs.sqlite"))
    columns = ",".join(c[1] for c in db.execute("PRAGMA table_info(job)") if c[1] not in ("seq", "id"))
    beside = lambda t: ",".join(c[1] for c in db.execute(f"PRAGMA table_info({t})") if c[1] != "seq")
    last = db.execute("SELECT max(seq) FROM job").fetchone()[0]
    numbers = "WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n WHERE i < %d)" % rows
    new_id = "printf('01908d7e-%04x-7%03x-8000-%012x', i / 65536, i % 4096, i + " + str(last) + ")"
    values = re.sub(r"\bturn\b", "turn + i", columns)
    if "job_blob" in "".join(statements):
        values = re.sub(r"\bkept\b", "0", values)  # these have no files; else the start forgets each upload by itself
    db.execute(f"{numbers} INSERT INTO job (seq, id, {columns}) SELECT {last} + i, {new_id}, {values} FROM n, job"
               f" WHERE seq = {last}")
    for table in ("job_text", "job_end"):
        db.execute(f"{numbers} INSERT INTO {table} (seq, {beside(table)}) SELECT {last} + i, {beside(table)} FROM n, {table} WHERE seq = {last}")
    for statement in statements:
        db.execute(f"{numbers} {statement}", {"last": last})
    ids = [row[0] for row in db.execute("SELECT id FROM job WHERE seq > ?", (last,))]
    db.commit()
    db.close()
    return ids


def lists(daemon, stop):
    connection = daemon.connect()
    while not stop.is_set():
        ask(connection, "GET", "/v1/jobs?processID=mesh")


daemon = Daemon()
connection = daemon.connect()
job = submit(connection)
while json.loads(ask(connection, "GET", "/v1/jobs/" + job)[1])["status"] != "successful":
    time.sleep(0.05)
daemon.stop()
fill("INSERT INTO event SELECT :last + i, attempt, last, randomblob(30000) FROM n, event WHERE seq = :last")
daemon = Daemon()
say("| beside %d jobs | what | median / p99 |\n|---|---|---|" % rows)
say("| ended | start of the daemon | %s |" % daemon.started)
cases = [("/livez", lambda c: ask(c, "GET", "/livez")), ("list ?name=nosuch", lambda c: ask(c, "GET", "/v1/jobs?name=nosuch")),
         ("newest page", lambda c: ask(c, "GET", "/v1/jobs")), ("submit with a quota of bytes", submit)]
measure(daemon, "ended", cases)
stop = threading.Event()
busy = [threading.Thread(target=lists, args=(daemon, stop)) for _ in range(4)]
[t.start() for t in busy]
measure(daemon, "ended, beside 4 who list what there is not", cases)
stop.set()
[t.join() for t in busy]
connection = daemon.connect()
submit(connection, "points=290&iterations=9999&delta=0")  # holds the only runner
waits = submit(connection)
daemon.process.kill()
daemon.process.wait()
ids = fill(rows=rows * 99 // 100)
db = sqlite3.connect(os.path.join(data, "jobs.sqlite"))
for name, bytes in db.execute("SELECT name, data FROM small_file WHERE name LIKE ?", (waits + ".%",)).fetchall():
    db.executemany("INSERT INTO small_file VALUES (?, ?, ?)", ((id + name[len(id):], len(bytes), bytes) for id in ids))
db.commit()
db.close()
daemon = Daemon()
say("| waiting | start of the daemon | %s |" % daemon.started)
say("| waiting | memory of the daemon | %s |" % re.search(r"VmRSS:\s*(.*)", open("/proc/%d/status" % daemon.process.pid).read()).group(1))
measure(daemon, "waiting", cases + [("status of a job", lambda c: ask(c, "GET", "/v1/jobs/" + waits))])
metrics = ask(http.client.HTTPConnection("127.0.0.1", daemon.admin), "GET", "/metrics")[1].decode()
say("".join("| waiting | %s | |\n" % line for line in metrics.splitlines() if re.match(r"voronoid_store_operation_(duration_)?seconds_(sum|count)", line)))
daemon.process.kill()
daemon.process.wait()
shutil.rmtree(data)
