/* One job on the page: what it is doing, how even its points are by now, what came of it. */
import { ask, askJson } from './api.js';
import { arrive } from './arrive.js';
import { drawChart } from './chart.js';
import { dropCloud, measures, readCloud } from './cloud.js';
import { $, count, roughly, show } from './dom.js';
import { showReport, summary } from './report.js';
import { canDraw, getCloud, setCloud, setLayout } from './stage.js';
import { showTakers } from './take.js';
import { isOver, watchJob } from './watch.js';

let release = () => {}, shown = null, records = [], frame = 0, fetching = false, tag = '';

const STEPS = { iterate: 'Iteration', polish: 'Polish step', project: 'Projection step', insert: 'Inserted point', baselines: 'Baseline', align: 'Alignment step' };
const WORDS = { successful: 'Done', failed: 'Failed', dismissed: 'Cancelled' };

function stateOf(status) {
    const { queuePosition, eta, stage } = status.voronoid;
    const parts = [WORDS[status.status] || (stage === 'optimize' ? 'Running' : status.message || status.status)];
    if (typeof queuePosition === 'number') parts.push(queuePosition ? `${count(queuePosition)} ahead in the queue` : 'next in the queue');
    if (!isOver(status) && stage !== 'optimize' && typeof eta === 'number') parts.push(`${roughly(eta)} left`);
    return parts.join(', ');
}

/* The live region is told of a new stage; figures that change ten times a second stand beside it. */
function showStatus(status) {
    shown = status;
    show($('watch'), true);
    const over = isOver(status), words = stateOf(status);
    $('watch-title').textContent = `${status.voronoid.name || 'Job'}: ${status.processID}`;
    if ($('state').textContent !== words) $('state').textContent = words;
    $('progress').value = status.progress;
    show($('stop'), status.status === 'running' && status.voronoid.stage === 'optimize' && status.processID !== 'register');
    show($('doing'), !over);
    show($('result'), over);
    if (status.exception) $('trouble').textContent = status.exception.detail || status.exception.title;
}

function draw() {
    frame = 0;
    show($('chart-box'), records.some((record) => Number.isFinite(record.best?.delta)));
    $('chart-words').textContent = drawChart($('chart'), records, shown?.processID === 'mesh');
}

function showRecords(all, latest) {
    records = all;
    frame = frame || requestAnimationFrame(draw);
    if (!latest || isOver(shown)) return;
    $('progress').value = latest.progress;
    const left = typeof latest.eta === 'number' ? `, ${roughly(latest.eta)} left` : '';
    const most = latest.of ? ` of at most ${count(latest.of)}` : '';
    $('figures').textContent = `${STEPS[latest.run_stage] || latest.run_stage} ${count(latest.step)}${most}${left}`;
}

function showLost(isLost) {
    $('figures').textContent = isLost ? 'The daemon does not answer. Trying again.' : '';
}

/* Shows the result, read as PLY in the frame of the input, unless another job is on the page by now. */
async function showResult(id, isProgressive) {
    const origin = getCloud('input')?.origin;
    const put = (cloud) => {
        if (shown?.jobID !== id) return dropCloud(cloud);
        const isFirst = !getCloud('result');
        setCloud('result', cloud);
        if (isFirst) setLayout(layoutOf());
        return undefined;
    };
    const answer = await ask(`v1/jobs/${id}/results/cloud?format=ply&link=false`);
    let coarse = null;
    const buffer = await arrive(answer, isProgressive, (first) => { coarse = readCloud(first, origin).then(put); });
    await coarse;
    put(await readCloud(buffer, origin));
}

/* Side by side: the input is what the result is judged by. */
const layoutOf = () => (getCloud('input') ? 'both' : 'result');

/* After its last step a job has no preview any more, and soon a result. */
const isEnding = () => records.length > 0 && records.at(-1).of > 0 && records.at(-1).step >= records.at(-1).of && !records.at(-1).ahead;

/* The points as they move: one picture at a time, none that nobody sees. They are shaded before they are shown. */
async function showPreview(id) {
    const input = getCloud('input');
    if (isEnding() || fetching || document.hidden || !canDraw() || !input || isOver(shown)) return;
    fetching = true;
    try {
        const answer = await ask(`v1/jobs/${id}/preview`, { more: { 'If-None-Match': tag } });
        if (answer.status === 304) return undefined; /* a poll begins with what the last one has told */
        tag = answer.headers.get('ETag') || '';
        const cloud = await readCloud(await answer.arrayBuffer(), input.origin);
        await Promise.all([measures.surface(cloud), measures.spacing(cloud)]);
        if (shown?.jobID !== id || isOver(shown) || getCloud('input') !== input) return dropCloud(cloud);
        const first = !getCloud('result');
        setCloud('result', cloud);
        if (first) setLayout(layoutOf());
        return undefined;
    } catch {
        return undefined; /* the job has ended meanwhile */
    } finally {
        fetching = false;
    }
}

async function showEnd(status) {
    const outputs = status.links.filter((link) => link.rel === 'item').map((link) => link.title);
    showStatus(status);
    $('figures').textContent = '';
    showTakers(status);
    if (status.status !== 'successful') {
        setCloud('result', null); /* of the points on the move nothing came */
        setLayout('input');
        return;
    }
    const told = outputs.find((name) => name !== 'cloud' && name !== 'soup');
    const report = told ? await askJson(`v1/jobs/${status.jobID}/results/${told}?link=false`) : null;
    if (shown?.jobID !== status.jobID) return;
    if (report) await showReport(status.processID, told, report);
    show($('report-box'), Boolean(report));
    if (!outputs.includes('cloud')) $('report-box').open = true; /* the report is what was asked for */
    $('summary').replaceChildren(...(report ? summary(report) : []));
    if (!outputs.includes('cloud') || !canDraw()) return;
    await showResult(status.jobID, report?.parameters?.order === 'progressive');
}

/** Takes the job off the page. */
export function leaveJob() {
    release();
    [release, shown, records, tag] = [() => {}, null, [], ''];
    for (const name of ['watch', 'result', 'doing', 'report-box', 'chart-box']) show($(name), false);
    $('report-box').open = false;
    for (const name of ['summary', 'figures', 'state', 'chart-words']) $(name).textContent = '';
    delete $('chart').dataset.points;
    setCloud('result', null);
    setLayout('input');
}

/** Shows that a job is on its way, before the daemon has said what it is like, so that its panel has its place at once. */
export function expectJob(words) {
    leaveJob();
    show($('watch'), true);
    $('watch-title').textContent = 'Job';
    $('state').textContent = words;
}

/** Shows a job and follows it; ended(status) is called when it is over. */
export function followJob(status, ended) {
    leaveJob();
    release = watchJob(status, { onStatus: showStatus, onRecords: showRecords, onPreview: () => showPreview(status.jobID), onLost: showLost, onEnd(last) {
        showEnd(last).catch((error) => { $('trouble').textContent = error.message; }).then(() => ended(last));
    } });
}

/** Wires stop and cancel; redraw() is for new colours. */
export function wireJob() {
    const tell = (method, path) => async () => {
        try {
            await ask(`v1/jobs/${shown.jobID}${path}`, { method });
        } catch (error) {
            $('trouble').textContent = error.message;
        }
    };
    $('stop').addEventListener('click', tell('POST', '/stop'));
    $('dismiss').addEventListener('click', tell('DELETE', ''));
    new ResizeObserver(draw).observe($('chart'));
}

export const redraw = () => draw();
