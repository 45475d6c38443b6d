/* The jobs that the daemon has, newest first; those begun elsewhere come by themselves. */
import { askJson } from './api.js';
import { $, count, make, show } from './dom.js';

const PAGE = 10;
const WORDS = { accepted: 'waiting', successful: 'done', dismissed: 'cancelled' }; /* failed is called that */
const AGAIN_MS = 5000; /* between two looks, of a page that is seen */
let next = '';

function row(job) {
    const name = job.voronoid.name || 'unnamed', when = new Date(job.created).toLocaleString();
    const state = job.status === 'running' ? `running, ${job.progress} %` : WORDS[job.status] || job.status;
    const link = make('a', { href: `#/jobs/${job.jobID}` }, `${name}: ${job.processID}`);
    const item = make('li', {}, link, make('small', {}, ` ${state}, ${count(job.voronoid.input?.points ?? 0)} input points, ${when}`));
    item.dataset.job = job.jobID;
    return item;
}

const load = async (path) => {
    const { jobs, links } = await askJson(path), more = links.find((link) => link.rel === 'next');
    return { jobs, more: more ? `v1/jobs${new URL(more.href).search}` : '' };
};

/** Shows the newest ones; older ones that were asked for stay. A row that is the same is left alone: it may have the focus. */
export async function showHistory() {
    const { jobs, more } = await load(`v1/jobs?limit=${PAGE}`), fresh = jobs.map(row), ids = new Set(jobs.map((job) => job.jobID));
    const before = /** @type {HTMLElement[]} */ ([...$('history').children]), last = before.map((one) => ids.has(one.dataset.job || '')).lastIndexOf(true);
    const older = last < 0 ? [] : before.slice(last + 1), same = (one) => before.find((old) => old.isEqualNode(one)) || one;
    if (!older.length) next = more;
    show($('history-more'), Boolean(next));
    const rows = [...fresh.map(same), ...older], wanted = rows.length ? rows : [same(make('li', { className: 'soft' }, 'No jobs yet.'))];
    if (wanted.length !== before.length || wanted.some((one, k) => one !== before[k])) $('history').replaceChildren(...wanted);
}

export function wireHistory() {
    const look = () => document.hidden || showHistory().catch(() => {}); /* what does not answer is told elsewhere */
    $('history-more').addEventListener('click', async () => {
        const { jobs, more } = await load(next);
        next = more;
        show($('history-more'), Boolean(next));
        $('history').append(...jobs.map(row));
    });
    document.addEventListener('visibilitychange', look);
    setInterval(look, AGAIN_MS);
}
