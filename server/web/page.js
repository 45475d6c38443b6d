/* The page: what happens in which order. */
import { ask, askJson, getKey, onRefused, setKey } from './api.js';
import { asked, blame, choose, loadProcesses, tellMesh } from './ask.js';
import { readCloud } from './cloud.js';
import { $, bytes, count, make, show } from './dom.js';
import { isPly, wireDrop } from './drop.js';
import { showHistory, wireHistory } from './history.js';
import { expectJob, followJob, leaveJob, redraw, wireJob } from './job.js';
import { startJob } from './send.js';
import { getCloud, setCloud, setLayout, wireStage } from './stage.js';
import { save, setName, wireCommands } from './take.js';
import { wireTheme } from './theme.js';
import { isOver, watchJob } from './watch.js';

/* What runs are made on: {file or null, name, job whose input or result it is}. job: the one that is shown. */
let source = null, job = '', turn = 0, beside; /* beside: the file of the reference that is drawn */

function complain(error) {
    $('trouble').textContent = error.status === 401 && !getKey() ? 'This daemon needs an API key. Enter it at the top of the page.' : error.message;
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
    const left = cloud.left ? `, ${count(cloud.left)} points left out because a coordinate is not finite` : '', faces = cloud.faces ? `, ${count(cloud.faces.length / 3)} triangles` : '';
    $('cloud-words').textContent = `${name}: ${count(cloud.n)} point${cloud.n === 1 ? '' : 's'}${faces}${left}${size ? `, ${bytes(size)}` : ''}`;
    setCloud('input', cloud);
    setLayout('input');
    tellMesh(Boolean(cloud.faces), Boolean(source.file));
    showReference();
}

const ended = (status) => new Promise((resolve) => {
    watchJob(status, { onStatus() {}, onRecords() {}, onPreview() {}, onLost() {}, onEnd: resolve });
});

/* What the page cannot read is sent, and read as the PLY that the daemon makes of it: the daemon has the last word on what is a cloud. */
async function convert(file, mine) {
    $('cloud-words').textContent = `Sending ${file.name} to the daemon, which converts it to PLY`;
    const status = await startJob('convert', { format: 'ply' }, { file, name: file.name });
    const last = await ended(status);
    if (last.status !== 'successful') throw Object.assign(new Error(last.exception?.detail || 'The daemon could not read the file.'), { status: 422 });
    if (mine === turn) source.job = last.jobID;
    return (await ask(`v1/jobs/${last.jobID}/results/cloud?link=false`)).arrayBuffer();
}

async function read(file, mine, origin) {
    const own = await isPly(file) ? await file.arrayBuffer().then((buffer) => readCloud(buffer, origin)).catch(() => null) : null;
    return own || readCloud(await convert(file, mine), origin);
}

/* The cloud that another one is to be laid on is drawn with it, before and after. */
async function drawReference() {
    const wanted = () => (asked().process === 'register' && getCloud('input') ? asked().files.reference : undefined);
    const file = wanted(), input = getCloud('input'), words = $('cloud-words').textContent;
    if (file === beside) return;
    beside = file;
    setCloud('reference', null);
    if (!file) return;
    const cloud = await read(file, 0, input.origin);
    $('cloud-words').textContent = words;
    if (wanted() === file && getCloud('input') === input) setCloud('reference', cloud);
}

const showReference = () => drawReference().catch(complain);

const isRefused = ({ status }) => status >= 400 && status < 500 && ![401, 403, 408, 429].includes(status);

const take = guarded(async (file) => {
    const mine = ++turn;
    source = { file, name: file.name, job: '' };
    job = '';
    setName(file.name);
    leaveJob();
    setCloud('input', null);
    showReference();
    if (location.hash !== '#/') history.pushState(null, '', '#/');
    $('cloud-words').textContent = `Reading ${file.name}`;
    $('run').disabled = false;
    try {
        const cloud = await read(file, mine);
        if (mine === turn) showInput(cloud, file.name, file.size);
    } catch (error) {
        if (mine !== turn) return;
        $('run').disabled = isRefused(error);
        $('cloud-words').textContent = isRefused(error) ? `${file.name} cannot be used. Choose another file, or convert it to PLY or Draco first.`
            : `${file.name} is not shown.`;
        throw error;
    }
});

/* To where the job is told of and its result is drawn. */
const goToResult = () => scrollTo(0, innerWidth > 800 ? 0 : $('stage').offsetTop);

const run = guarded(async () => {
    const { process, values, files } = asked(), wasThere = !$('watch').hidden;
    if (!source) throw new Error('Choose a cloud first.');
    blame([]);
    $('run').disabled = true;
    if (!wasThere) expectJob('Sending the request');
    try {
        const status = await startJob(process, values, source, files);
        source.job = status.links.some((link) => link.rel === 'input') ? status.jobID : source.job;
        job = status.jobID;
        location.hash = `#/jobs/${job}`;
        followJob(status, () => showHistory());
        goToResult();
        showHistory();
    } catch (error) {
        if (!wasThere) leaveJob();
        throw error;
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
    expectJob('Opening the job');
    goToResult();
    setCloud('input', null);
    showReference();
    [job, source] = [id, null];
    $('run').disabled = true;
    $('cloud-words').textContent = '';
    const status = await askJson(`v1/jobs/${id}`).catch((error) => {
        if (mine === turn) leaveJob();
        throw error;
    });
    const name = status.voronoid.name || 'cloud';
    if (mine !== turn) return;
    source = { file: null, name, job: id };
    setName(name);
    $('cloud-words').textContent = `Fetching ${name}`;
    $('run').disabled = false;
    choose(status.processID, status.voronoid.parameters);
    if (!isOver(status)) followJob(status, () => showHistory()); /* the chart grows while the input comes */
    else $('watch-title').textContent = `${name}: ${status.processID}`;
    const cloud = await fetchInput(status).catch(() => null);
    if (mine !== turn) return;
    if (cloud) showInput(cloud, name, status.voronoid.input?.bytes);
    else $('cloud-words').textContent = `${name}: the daemon no longer has this input`;
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
for (const what of ['change', 'click']) $('ask').addEventListener(what, showReference);
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
askJson('version').then(({ version }) => { $('version').replaceChildren(make('span', { className: 'wide' }, 'version '), version); }, () => {});
guarded(begin)();
