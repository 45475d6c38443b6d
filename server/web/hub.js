/* One stream of events for all jobs that anybody watches: a browser opens six connections to a daemon, and eight tabs with a stream
 * each would wait for each other. It lives in the SharedWorker (stream.js), or in the page where there is none. */

const JOBS_MAX = 64;      /* of one stream, by the daemon's contract */
const AGAIN_MS = 2000;    /* before a stream that broke is opened again, or a daemon without streams is asked again */
const SETTLE_MS = 60;     /* during which more tabs may ask, before a stream is opened anew */
const PREVIEW_POINTS = 50000; /* as many as the daemon shows of points on the move */
const POLL_SECONDS = 10;  /* that a poll may wait for news */
const POLLS_WAITING = 2;  /* at a time: of six connections the page needs some; other jobs are asked for now and then */
const POLL_PAUSE_MS = 300; /* between an answer with news and the next question: a run has news at every step */

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
 *  trace says, or 0.0); a watcher is a function that gets {event, data}, some events twice when another one comes. root: where the
 *  daemon is; key: what it wants. isSeen() tells whether somebody looks: the hub of a page that nobody sees keeps no connection, but asks
 *  now and then; again() is for when that has changed. */
export function makeHub(root, key, isSeen = () => true) {
    const watched = new Map(); /* id: {watchers, position, over} */
    const headers = (more) => (key ? { Authorization: `Bearer ${key}`, ...more } : more);
    let control = null, timer = 0;

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

    /* Asks for a job's status again and again, each time until it has changed. */
    async function poll(id, signal, waits) {
        for (let tag = ''; !signal.aborted && watched.has(id);) {
            if (tag) await new Promise((resolve) => { setTimeout(resolve, waits ? POLL_PAUSE_MS : AGAIN_MS); });
            const answer = await fetch(new URL(`v1/jobs/${id}`, root), { signal, cache: 'no-store',
                headers: headers({ ...(waits ? { Prefer: `wait=${POLL_SECONDS}` } : {}), ...(tag ? { 'If-None-Match': tag } : {}) }) });
            tag = answer.headers.get('ETag') || '';
            if (answer.status === 200) {
                const data = await answer.json();
                tell(id, 'polled', data);
                if (!['accepted', 'running'].includes(data.status)) {
                    if (watched.has(id)) watched.get(id).over = true;
                    return tell(id, 'end', data);
                }
            } else if (answer.status !== 304) return tell(id, 'unknown', { jobID: id });
        }
        return undefined;
    }

    async function follow(ids, signal) {
        const last = ids.map((id) => watched.get(id).position).join(','), query = `jobs=${ids.join(',')}&lastEventId=${last}&preview=${PREVIEW_POINTS}`;
        if (!isSeen()) return Promise.all(ids.map((id) => poll(id, signal, false)));
        const answer = await fetch(new URL(`v1/events?${query}`, root),
            { signal, headers: headers({ Accept: 'application/x-ndjson' }), cache: 'no-store' });
        /* A daemon that has all the streams it may have answers 200 too, with no lines but when to come again. */
        if (answer.status === 200 && /ndjson/.test(answer.headers.get('Content-Type')))
            for await (const line of lines(answer.body)) hear(ids, JSON.parse(line));
        else if (answer.status !== 204) await Promise.all(ids.map((id, k) => poll(id, signal, k < POLLS_WAITING)));
        return undefined;
    }

    async function open() {
        const ids = live();
        if (control) control.abort();
        control = new AbortController();
        const { signal } = control;
        if (!ids.length) return;
        try {
            await follow(ids, signal);
        } catch {
            /* the connection broke, or was given up for another */
        }
        if (!signal.aborted && live().length) later(AGAIN_MS);
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
