/* Follows a job: its status, its records from the first on, its end. */
import { ROOT, askJson, getKey } from './api.js';
import { makeHub } from './hub.js';

const QUEUE_MS = 2000; /* between questions how many jobs are before this one */
const [FOCUS_SECONDS, SEEN_SECONDS] = [10, 1]; /* that a tab without SharedWorker waits for news at a time */
const told = new Map(); /* id: what to call */
let port = null, hub = null;

const hear = ({ event, data }) => told.get(data.jobID)?.(event, data);

/* Without a SharedWorker, or one that cannot be had, each tab polls for itself. Of six connections the tab that has the focus holds one;
 * of windows side by side the others hold theirs for a moment; a tab that nobody sees holds none. */
function alone() {
    hub = makeHub(ROOT, getKey, () => (document.hidden ? 0 : document.hasFocus() ? FOCUS_SECONDS : SEEN_SECONDS));
    document.addEventListener('visibilitychange', hub.again);
    for (const name of ['focus', 'blur']) addEventListener(name, hub.again);
}

/* Browsers without have none, those that may remember nothing give none. */
function sharedWorker() {
    try {
        return new SharedWorker(new URL('stream.js', import.meta.url), { name: 'voronoid' });
    } catch {
        return null;
    }
}

function connect() {
    const worker = sharedWorker();
    if (!worker) return alone();
    port = worker.port;
    port.onmessage = ({ data }) => hear(data);
    worker.onerror = () => {
        port = null;
        if (!hub) alone();
        told.forEach((_, id) => join(id, '0.0'));
    };
    addEventListener('pagehide', () => port?.postMessage({ gone: true }));
    return addEventListener('pageshow', (event) => event.persisted && [...told.keys()].forEach((id) => join(id, '0.0')));
}

function join(id, position) {
    if (!port && !hub) connect();
    if (port) port.postMessage({ root: String(ROOT), key: getKey(), watch: id, position });
    else hub.watch(hear, id, position);
}

function part(id) {
    told.delete(id);
    if (port) port.postMessage({ leave: id });
    else hub?.leave(hear, id);
}

export const isOver = (status) => !['accepted', 'running'].includes(status.status);

/* A record's place on the curve; a stream that begins anew tells some of them twice. */
const place = (record) => `${record.attempt} ${record.run_stage} ${record.iteration} ${record.polish} ${record.step} ${record.delta}`;

/** Follows a job whose status is known. onStatus(status), onRecords(all records so far, in order), onPreview(), onLost(whether the daemon
 *  does not answer), onEnd(status). Returns a function that lets go. */
export function watchJob(status, { onStatus, onRecords, onPreview, onLost, onEnd }) {
    const id = status.jobID, records = new Map();
    let alive = true, attempt = 0, timer = 0;
    const add = (record) => {
        if (record.attempt < attempt) return;
        if (record.attempt > attempt) records.clear();
        attempt = record.attempt;
        records.set(place(record), record);
    };
    const all = () => [...records.values()].sort((a, b) => a.seconds - b.seconds);
    const trace = async () => {
        const table = await askJson(`v1/jobs/${id}/trace`).catch(() => null);
        if (!alive || !table) return '0.0';
        table.records.forEach((record) => add({ ...record, attempt: table.attempt }));
        onRecords(all());
        return table.lastEventId || '0.0';
    };
    const finish = async () => {
        part(id);
        clearTimeout(timer);
        const last = await askJson(`v1/jobs/${id}`);
        await trace();
        if (alive) onEnd(last);
    };
    /* The stream goes on where the trace ends, unless that was the end of the job. */
    const begin = async () => {
        const position = await trace(), now = await askJson(`v1/jobs/${id}`);
        if (alive && isOver(now)) await finish();
        else if (alive) join(id, position);
    };
    /* No event says that others have left the queue: who waits there asks. */
    const tell = (now) => {
        clearTimeout(timer);
        onStatus(now);
        timer = now.status === 'accepted' ? setTimeout(look, QUEUE_MS, now) : 0;
    };
    const look = async (before) => {
        const mine = timer, now = document.hidden ? before : await askJson(`v1/jobs/${id}`).catch(() => before);
        if (alive && timer === mine && !isOver(now)) tell(now);
    };
    tell(status);
    if (isOver(status)) {
        trace().then(() => alive && onEnd(status));
        return () => { alive = false; };
    }
    told.set(id, (event, data) => {
        if (!alive) return;
        if (event === 'status') tell(data);
        if (event === 'preview') onPreview();
        if (event === 'lost' || event === 'found') onLost(event === 'lost');
        if (event === 'progress') {
            add(data);
            onRecords(all(), data);
        }
        if (event === 'end' || event === 'unknown') finish().catch(() => {});
    });
    begin().catch(() => alive && join(id, '0.0'));
    return () => {
        alive = false;
        clearTimeout(timer);
        if (told.has(id)) part(id);
    };
}
