/* The jobs that the daemon has, newest first. */
import { askJson } from './api.js';
import { $, count, make, show } from './dom.js';

const PAGE = 10;
let next = '';

function row(job) {
    const name = job.voronoid.name || 'unnamed', when = new Date(job.created).toLocaleString();
    const state = job.status === 'running' ? `${job.progress} %` : job.status;
    const link = make('a', { href: `#/jobs/${job.jobID}` }, `${name}: ${job.processID}`);
    return make('li', {}, link, make('small', {}, ` ${state}, ${count(job.voronoid.input?.points ?? 0)} points in, ${when}`));
}

async function load(path) {
    const { jobs, links } = await askJson(path), more = links.find((link) => link.rel === 'next');
    next = more ? `v1/jobs${new URL(more.href).search}` : '';
    show($('history-more'), Boolean(next));
    return jobs.map(row);
}

/** Shows the newest ones. */
export async function showHistory() {
    const rows = await load(`v1/jobs?limit=${PAGE}`);
    $('history').replaceChildren(...(rows.length ? rows : [make('li', { className: 'soft' }, 'None yet.')]));
}

export function wireHistory() {
    $('history-more').addEventListener('click', async () => $('history').append(...await load(next)));
}
