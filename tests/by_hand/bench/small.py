#!/usr/bin/python3
"""usage: small.py VORONOID...: what a job of 1,000 points costs over HTTP, by each of the binaries in turn (ROUNDS, 3): the time
alone, and of that what is beside the seconds of its report; CPU of all processes; jobs a second by 16 clients. DATA is the folder
of the daemon's data: memory (/dev/shm) where none is given, so that no sync takes time. SYNCS=1 counts syncs with strace."""
import json, os, re, shutil, signal, socket, statistics, struct, subprocess, sys, tempfile, threading, time, random

binaries = sys.argv[1:]
rounds, alone, clients, each = int(os.environ.get("ROUNDS", 3)), int(os.environ.get("ALONE", 40)), 16, int(os.environ.get("EACH", 12))
base = os.environ.get("DATA") or "/dev/shm"
random.seed(1)
points = [[random.gauss(0, 1) for _ in range(3)] for _ in range(1000)]
lengths = [sum(x * x for x in p) ** .5 for p in points]
cloud = b"ply\nformat binary_little_endian 1.0\nelement vertex 1000\nproperty float x\nproperty float y\nproperty float z\nend_header\n" \
    + b"".join(struct.pack("<3f", *(x / r for x in p)) for p, r in zip(points, lengths))
requests = [("convert", "/v1/convert"), ("convert to Draco", "/v1/convert?format=drc"),
            ("iterations=1", "/v1/resample?points=1000&iterations=1&polish=0"), ("default", "/v1/resample?points=1000")]
ticks = os.sysconf("SC_CLK_TCK")


class Daemon:
    def __init__(self, binary):
        self.data = tempfile.mkdtemp(dir=base)
        log = os.path.join(self.data, "log")
        self.process = subprocess.Popen([binary, "serve", "--listen", "127.0.0.1:0", "--data", os.path.join(self.data, "d"),
            "--queue", "1000"], stderr=open(log, "w"))
        while not (found := re.search(r'"address":"127.0.0.1:(\d+)"', open(log).read())):
            assert self.process.poll() is None, open(log).read()
            time.sleep(0.02)
        self.port = int(found.group(1))

    def connect(self):
        s = socket.create_connection(("127.0.0.1", self.port))
        s.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        return s

    def ask(self, s, path, body=None):
        head = "%s %s HTTP/1.1\r\nHost: localhost\r\n" % ("GET" if body is None else "POST", path)
        if body is not None:
            head += "Content-Type: application/octet-stream\r\nContent-Length: %d\r\n" % len(body)
        s.sendall(head.encode() + b"\r\n" + (body or b""))
        got = b""
        while b"\r\n\r\n" not in got:
            more = s.recv(1 << 16)
            assert more, got
            got += more
        head, body = got.split(b"\r\n\r\n", 1)
        size = int(re.search(rb"(?i)content-length: (\d+)", head).group(1))
        while len(body) < size:
            body += s.recv(1 << 16)
        assert head.startswith(b"HTTP/1.1 200"), head + body
        return head, body

    def job(self, s, path):
        return self.ask(s, path, cloud)[0]

    def run_ms(self, s, head):
        job = re.search(rb"(?i)location: http://[^/]+(/\S+)", head)
        report = json.loads(self.ask(s, job.group(1).decode() + "/results/report")[1])
        return 1e3 * sum(report.get("seconds", {}).values())

    def processes(self):
        todo, all = [self.process.pid], []
        while todo:
            all.append(todo.pop())
            try:
                todo += map(int, open("/proc/%d/task/%d/children" % (all[-1], all[-1])).read().split())
            except OSError:
                all.pop()
        return all

    def cpu_ms(self):
        ms = 0
        for pid in self.processes():
            try:
                text = open("/proc/%d/stat" % pid).read()
            except OSError:
                continue  # a codec process that has ended: its zygote tells of it
            field = text[text.rindex(")") + 2:].split()
            ended = 2 if "(vor-zygote)" in text else 0  # codec processes that have ended
            ms += sum(map(int, field[11:13 + ended]))
        return 1e3 * ms / ticks

    def syncs(self, s, path):
        out = os.path.join(self.data, "strace")
        tracer = subprocess.Popen(["strace", "-qf", "-e", "trace=fsync,fdatasync,sync_file_range", "-o", out]
            + [a for pid in self.processes() for a in ("-p", str(pid))], stderr=subprocess.DEVNULL)
        time.sleep(1)
        for _ in range(10):
            self.job(s, path)
        tracer.send_signal(signal.SIGINT)
        tracer.wait()
        return len(re.findall(r"sync\(", open(out).read())) / 10

    def stop(self):
        self.process.send_signal(signal.SIGTERM)
        self.process.wait()
        shutil.rmtree(self.data)


def measure(daemon, path, got):
    s = daemon.connect()
    daemon.job(s, path)
    took, beside = [], []
    before = daemon.cpu_ms()
    for _ in range(alone):
        began = time.perf_counter()
        head = daemon.job(s, path)
        took.append(1e3 * (time.perf_counter() - began))
        beside.append(took[-1] - daemon.run_ms(s, head))
    got.setdefault("CPU ms alone", []).append((daemon.cpu_ms() - before) / alone)
    got.setdefault("ms", []).append(statistics.median(took))
    got.setdefault("beside the run", []).append(statistics.median(beside))

    def client():
        s = daemon.connect()
        for _ in range(each):
            daemon.job(s, path)
    threads = [threading.Thread(target=client) for _ in range(clients)]
    before, began = daemon.cpu_ms(), time.perf_counter()
    [t.start() for t in threads]
    [t.join() for t in threads]
    got.setdefault("jobs a second", []).append(clients * each / (time.perf_counter() - began))
    got.setdefault("CPU ms", []).append((daemon.cpu_ms() - before) / clients / each)
    if os.environ.get("SYNCS"):
        got.setdefault("syncs", []).append(daemon.syncs(s, path))


daemons = [Daemon(b) for b in binaries]
try:
    for name, path in requests:
        if not re.search(os.environ.get("ONLY", ""), name):
            continue
        got = [{} for _ in daemons]
        for _ in range(rounds):
            for d, g in zip(daemons, got):
                measure(d, path, g)
        for b, g in zip(binaries, got):
            print("| %s | %s | %s |" % (name, b[-30:], " | ".join("%s %.2f" % (k, statistics.median(v)) for k, v in g.items())), flush=True)
    for b, d in zip(binaries, daemons):
        time.sleep(12)  # threads that have nothing to do end
        print("| idle | %s | threads %d |" % (b[-30:], len(os.listdir("/proc/%d/task" % d.process.pid))))
finally:
    for d in daemons:
        d.stop()
