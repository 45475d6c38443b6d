/* The page: what happens in which order. */
import { ask, askJson, getKey, onRefused, setKey } from './api.js';
import { asked, blame, choose, loadProcesses, tellMesh } from './ask.js';
import { readCloud } from './cloud.js';
import { $, bytes, count, show } from './dom.js';
import { isPly, wireDrop } from './drop.js';
import { showHistory, wireHistory } from './history.js';
import { followJob, leaveJob, redraw, wireJob } from './job.js';
import { startJob } from './send.js';
import { setCloud, setLayout, wireStage } from './stage.js';
import { save, setName, wireCommands } from './take.js';
import { wireTheme } from './theme.js';
import { isOver, watchJob } from './watch.js';

/* What runs are made on: {file or null, name, job whose input or result it is}. job: the one that is shown. */
let source = null, job = '', turn = 0;

function complain(error) {
    $('trouble').textContent = error.status === 401 && !getKey() ? 'This daemon wants a key: its field is at the top.' : error.message;
    if (error.errors) blame(error.errors);
}

/* Runs what a control asks for, once: the control waits, and what goes wrong is said. */
const guarded = (work) => async (...given) => {
    $('trouble').textContent = '';
    try {
        await work(...given);
    } catch (error) {
        complain(error);
    }
};

function showInput(cloud, name, size) {
    const left = cloud.left ? `, ${count(cloud.left)} that are not finite left out` : '', faces = cloud.faces ? `, ${count(cloud.faces.length / 3)} triangles` : '';
    $('cloud-words').textContent = `${name}: ${count(cloud.n)} point${cloud.n === 1 ? '' : 's'}${faces}${left}${size ? `, ${bytes(size)}` : ''}`;
    setCloud('input', cloud);
    setLayout('input');
    tellMesh(Boolean(cloud.faces), Boolean(source.file));
}

const ended = (status) => new Promise((resolve) => {
    watchJob(status, { onStatus() {}, onRecords() {}, onPreview() {}, onLost() {}, onEnd: resolve });
});

/* Formats that the page does not read are sent, and read as the PLY that the daemon makes of them. */
async function convert(file, mine) {
    $('cloud-words').textContent = `${file.name}: is sent, to be read by the daemon`;
    const status = await startJob('convert', { format: 'ply' }, { file, name: file.name });
    const last = await ended(status);
    if (last.status !== 'successful') throw new Error(last.exception?.detail || 'The daemon could not read it.');
    if (mine === turn) source.job = last.jobID;
    return (await ask(`v1/jobs/${last.jobID}/results/cloud`)).arrayBuffer();
}

const take = guarded(async (file) => {
    const mine = ++turn;
    source = { file, name: file.name, job: '' };
    job = '';
    setName(file.name);
    leaveJob();
    setCloud('input', null);
    if (location.hash !== '#/') history.pushState(null, '', '#/');
    $('cloud-words').textContent = `${file.name}: is read`;
    $('run').disabled = false;
    try {
        const cloud = await readCloud(await isPly(file) ? await file.arrayBuffer() : await convert(file, mine));
        if (mine === turn) showInput(cloud, file.name, file.size);
    } catch (error) {
        if (mine === turn) $('cloud-words').textContent = `${file.name} is not shown`;
        throw error;
    }
});

const run = guarded(async () => {
    const { process, values, files } = asked();
    if (!source) throw new Error('Choose a cloud first.');
    blame([]);
    $('run').disabled = true;
    try {
        const status = await startJob(process, values, source, files);
        source.job = status.links.some((link) => link.rel === 'input') ? status.jobID : source.job;
        job = status.jobID;
        location.hash = `#/jobs/${job}`;
        followJob(status, () => showHistory());
        $('watch').scrollIntoView({ block: 'nearest' });
        showHistory();
    } finally {
        $('run').disabled = false;
    }
});

/* The input of a job that was not started here, or before a reload. */
async function fetchInput(status) {
    const link = status.links.find((one) => one.rel === 'input');
    if (!link) return null;
    const path = /ply/.test(link.type) ? `v1/jobs/${status.jobID}/input` : `v1/convert?format=ply&input=job:${status.jobID}`;
    const answer = await ask(path, { method: /ply/.test(link.type) ? 'GET' : 'POST' });
    return readCloud(await answer.arrayBuffer());
}

const openJob = guarded(async (id) => {
    const mine = ++turn;
    leaveJob();
    setCloud('input', null);
    [job, source] = [id, null];
    $('run').disabled = true;
    $('cloud-words').textContent = '';
    const status = await askJson(`v1/jobs/${id}`), name = status.voronoid.name || 'cloud';
    if (mine !== turn) return;
    source = { file: null, name, job: id };
    setName(name);
    $('cloud-words').textContent = `${name}: is fetched`;
    $('run').disabled = false;
    choose(status.processID, status.voronoid.parameters);
    if (!isOver(status)) followJob(status, () => showHistory()); /* the chart grows while the input comes */
    const cloud = await fetchInput(status).catch(() => null);
    if (mine !== turn) return;
    if (cloud) showInput(cloud, name, status.voronoid.input?.bytes);
    else $('cloud-words').textContent = `${name}: the daemon has let its input go`;
    if (!cloud) source = null;
    $('run').disabled = !source;
    if (isOver(status)) followJob(status, () => {});
});

function route() {
    const id = /^#\/jobs\/([\w-]+)$/.exec(location.hash)?.[1] || '';
    if (id && id !== job) openJob(id);
    else if (!id && job) {
        job = '';
        leaveJob();
    }
}

async function begin() {
    await loadProcesses();
    if (!$('key-form').hidden) $('file').focus();
    show($('key-form'), false);
    show($('forget'), Boolean(getKey()));
    await showHistory();
    route();
}

const recolour = wireStage(save);
wireTheme($('theme'), () => {
    recolour();
    redraw();
});
wireDrop(take);
wireJob();
wireCommands();
wireHistory();
onRefused(() => {
    show($('key-form'), true);
    $('key').focus();
});
$('ask').addEventListener('submit', (event) => {
    event.preventDefault();
    run();
});
/* A field that is folded away could not be pointed at. */
$('ask').addEventListener('invalid', (event) => /** @type {Element} */ (event.target).closest('details')?.setAttribute('open', ''), true);
$('key-form').addEventListener('submit', (event) => {
    event.preventDefault();
    setKey($('key').value.trim());
    $('key').value = '';
    job = ''; /* one that was followed with another key is opened again */
    guarded(begin)();
});
$('forget').addEventListener('click', () => {
    setKey('');
    location.reload();
});
addEventListener('hashchange', route);
askJson('version').then(({ version }) => { $('version').textContent = `version ${version}`; }, () => {});
guarded(begin)();
