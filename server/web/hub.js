/* The events of all jobs that anybody watches: a browser opens six connections to a daemon, and eight tabs with a stream each would wait
 * for each other. In the SharedWorker (stream.js) they are one stream, or polls where the daemon has as many streams as it may; where there
 * is no SharedWorker, each page polls for itself. */

const JOBS_MAX = 64;      /* of one stream, by the daemon's contract */
const AGAIN_MS = 2000;    /* before a stream that broke is opened again, or a page that nobody sees asks again */
const SETTLE_MS = 60;     /* during which more tabs may ask, before a stream is opened anew */
const PREVIEW_POINTS = 50000; /* as many as the daemon shows of points on the move */
const POLL_SECONDS = 10;  /* that a poll waits for news, where there are no streams */
const CROWDED_MS = 10000; /* before a daemon that had all the streams it may have is asked for one again, as it says itself */
const PAUSE_MS = 300;     /* after a poll that brought some: a run has news at every step */

async function* lines(body) {
    const reader = body.pipeThrough(new TextDecoderStream()).getReader();
    for (let rest = ''; ;) {
        const { done, value } = await reader.read();
        if (done) return;
        const parts = (rest + value).split('\n');
        rest = parts.pop();
        yield* parts.filter(Boolean);
    }
}

/** Makes a hub. watch(watcher, id, position) and leave(watcher, id) say who wants to hear of which job, from which event on (what its
 *  trace says, or 0.0); a watcher is a function that gets {event, data}, some events twice when another one comes; besides those of
 *  the daemon, lost when it does not answer and found when it does again. root: where the daemon is; key: tells what it wants. patience:
 *  for a page's own hub, which has no stream: how many seconds a poll may wait for news now; 0 keeps no connection, but asks now and then.
 *  again() is for when that has changed. */
export function makeHub(root, key, patience) {
    const watched = new Map(); /* id: {watchers, position, over} */
    const headers = (more) => (key() ? { Authorization: `Bearer ${key()}`, ...more } : more);
    let control = null, timer = 0, streamsAt = 0, isLost = false;

    const tell = (id, event, data) => watched.get(id)?.watchers.forEach((watcher) => watcher({ event, data }));
    const later = (ms) => {
        clearTimeout(timer);
        timer = setTimeout(open, ms);
    };
    const live = () => [...watched].filter(([, job]) => !job.over).map(([id]) => id).slice(-JOBS_MAX);

    function hear(ids, { event, id, data }) {
        const positions = (id || '').split(',');
        ids.forEach((one, k) => { if (watched.has(one) && positions[k]) watched.get(one).position = positions[k]; });
        if (watched.has(data.jobID) && (event === 'end' || event === 'unknown')) watched.get(data.jobID).over = true;
        tell(data.jobID, event, data);
    }

    /* Asks for the events of jobs and hears what comes; the answer, or null where none of these came. */
    async function ask(ids, signal, { isShown, more }) {
        const last = ids.map((id) => watched.get(id).position).join(',');
        const query = `jobs=${ids.join(',')}&lastEventId=${last}${isShown ? `&preview=${PREVIEW_POINTS}` : ''}`;
        const answer = await fetch(new URL(`v1/events?${query}`, root),
            { signal, headers: headers({ Accept: 'application/x-ndjson', ...more }), cache: 'no-store' });
        if (isLost) ids.forEach((id) => tell(id, 'found', { jobID: id }));
        isLost = false;
        if (answer.status === 204) return answer;
        if ([400, 401, 403, 404].includes(answer.status)) /* the key, say: the page asks for the job, and learns why */
            ids.forEach((id) => hear([], { event: 'unknown', id: '', data: { jobID: id } }));
        if (answer.status !== 200 || !/ndjson/.test(answer.headers.get('Content-Type'))) return null;
        for await (const line of lines(answer.body)) hear(ids, JSON.parse(line));
        return answer;
    }

    /* Resolves to how long to wait before the next time. */
    async function follow(ids, signal) {
        if (!patience && Date.now() >= streamsAt) {
            if (await ask(ids, signal, { isShown: true, more: {} })) return AGAIN_MS;
            streamsAt = Date.now() + CROWDED_MS;
        }
        const seconds = patience ? patience() : POLL_SECONDS;
        const polled = await ask(ids, signal, { isShown: seconds > 0, more: { Prefer: `wait=${seconds}` } });
        return polled && seconds ? PAUSE_MS : AGAIN_MS;
    }

    async function open() {
        const ids = live();
        if (control) control.abort();
        control = new AbortController();
        const { signal } = control;
        if (!ids.length) return;
        const pause = await follow(ids, signal).catch(() => {
            if (signal.aborted) return 0; /* given up for another */
            isLost = true;
            ids.forEach((id) => tell(id, 'lost', { jobID: id }));
            return AGAIN_MS;
        });
        if (!signal.aborted && live().length) later(pause);
    }

    return {
        watch(watcher, id, position) {
            if (!watched.has(id)) watched.set(id, { watchers: new Set() });
            const job = watched.get(id);
            Object.assign(job, { position, over: false });
            job.watchers.add(watcher);
            later(SETTLE_MS);
        },
        leave(watcher, id) {
            const job = watched.get(id);
            if (!job || !job.watchers.delete(watcher) || job.watchers.size) return;
            watched.delete(id);
            later(SETTLE_MS);
        },
        again: () => later(SETTLE_MS),
    };
}
