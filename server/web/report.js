/* The report of a job: every figure, with its unit and what it means in the words of the process description. */
import { askJson } from './api.js';
import { $, figure, make } from './dom.js';

const descriptions = new Map();

async function describe(process) {
    if (!descriptions.has(process)) descriptions.set(process, await askJson(`v1/processes/${process}`));
    return descriptions.get(process);
}

/* What parameters are called in the form stands for what they mean. */
const meanings = (inputs) => ({ properties: Object.fromEntries(Object.entries(inputs)
    .map(([name, { title, schema }]) => [name, { description: title, 'x-unit': schema['x-unit'] }])) });

/* Why a run ended, as people say it. */
const ENDED = { iterations: 'all its steps are done', delta: 'even enough', seconds: 'its time was over', plateau: 'it became no more even',
    moveStop: 'its points moved no more', stopped: 'stopped by its caller, the best kept' };

const plain = (value) => value === null || typeof value !== 'object';

const item = (one) => (plain(one) ? figure(one) : Object.entries(one).map(([name, value]) => `${name} ${words(value)}`).join(' · '));

function words(value) {
    if (value === null) return 'none';
    if (Array.isArray(value)) return value.length ? value.map(item).join(', ') : 'none';
    return figure(value);
}

/* A list of figures is a line; of things with members each has its own. */
function shownOf(value) {
    if (!Array.isArray(value) || !value.length || value.every(plain)) return [words(value)];
    return value.map((one) => make('span', { className: 'line' }, item(one)));
}

function row(name, value, schema) {
    const shown = make('span', {}, ...shownOf(value)), unit = schema?.['x-unit'];
    if (unit && typeof value === 'number') shown.append(make('small', {}, ` ${unit}`));
    const parts = name.split(/(?<=_)/).flatMap((part) => [make('wbr'), part]); /* a long name may be broken there */
    return [make('dt', {}, ...parts), make('dd', {}, shown, schema?.description ? make('small', { className: 'meaning' }, schema.description) : '')];
}

/* Members of members are rows with names of two parts; what the job was asked for stands apart. */
function rows(report, schema, prefix = '') {
    return Object.entries(report).flatMap(([name, value]) => {
        const own = schema?.properties?.[name];
        if (plain(value) || Array.isArray(value)) return row(prefix + name, value, own);
        return rows(value, own, `${prefix}${name} · `);
    });
}

/* How far input and result lie from each other, of both ways at once. */
function apart({ ref_to_out: there, out_to_ref: back }, unit) {
    if (!there || !back) return [];
    const far = (name, value, description) => row(name, value, { description, 'x-unit': unit });
    return [make('h3', {}, 'Beside the input'), make('dl', {},
        ...far('Mean distance', there.mean, 'From a point of the input to the nearest one of the result: where there are fewer of those, some part '
            + 'of their spacing'),
        ...far('Mean distance back', back.mean, 'From a point of the result to the nearest one of the input: how close it keeps to it'),
        ...far('Hausdorff distance', Math.max(there.max, back.max), 'The greatest of all these distances, both ways')), make('h3', {}, 'All figures')];
}

/** Fills the panel with a report or document. */
export async function showReport(process, output, report) {
    const { inputs, outputs } = await describe(process).catch(() => ({ inputs: {}, outputs: {} })), { parameters, ...figures } = report;
    const list = make('dl', {}, ...rows(figures, outputs[output]?.schema));
    $('report').replaceChildren(...apart(figures, 'unit of the cloud'), list);
    if (parameters) $('report').append(make('h3', {}, 'As it was asked for'), make('dl', {}, ...rows(parameters, meanings(inputs))));
}

/** One sentence about a result, as parts of a paragraph in which no figure is broken. */
export function summary(report) {
    if (typeof report.delta !== 'number') return [];
    const parts = [`δ ${figure(report.delta)}`, `σ ${figure(report.sigma)}`, `ε ${report.epsilon.toFixed(5)}`];
    if (report.points) parts.unshift(`${figure(report.points.in)} → ${figure(report.points.out)} points`);
    if (report.stopped) parts.push(ENDED[report.stopped] || report.stopped);
    return parts.flatMap((part, k) => [k ? ' · ' : '', make('span', { className: 'whole' }, part)]);
}
