/* The report of a job: every figure, with its unit and what it means in the words of the process description. */
import { askJson } from './api.js';
import { $, brief, figure, make } from './dom.js';

const descriptions = new Map();

async function describe(process) {
    if (!descriptions.has(process)) descriptions.set(process, await askJson(`v1/processes/${process}`));
    return descriptions.get(process);
}

/* What parameters are called in the form stands for what they mean. */
const meanings = (inputs) => ({ properties: Object.fromEntries(Object.entries(inputs)
    .map(([name, { title, schema }]) => [name, { description: title, 'x-unit': schema['x-unit'] }])) });

/* Why a run ended, as people say it. */
const ENDED = { delta: 'stopped at the requested δ', eta: 'stopped at the requested η', seconds: 'stopped at its time limit', moveStop: 'stopped because points hardly moved',
    stopped: 'you stopped it early' };

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

/* The figures that most people look for, each with its meaning. */
function headline({ points, delta, spacing, seconds, ref_to_out: there, out_to_ref: back }) {
    const all = [];
    const add = (name, value, unit, description) => typeof value === 'number' && all.push(...row(name, value, { description, 'x-unit': unit }));
    add('Points', points?.out, '', `Number of points of the result. The input has ${figure(points?.in ?? 0)} points`);
    add('Unevenness δ', delta, '', 'How much the distances between neighbours vary: their standard deviation divided by their mean. 0 is perfectly even');
    add('Spacing', spacing, 'unit of the cloud', 'Mean distance from a point to its nearest neighbour');
    if (there && back) {
        add('Distance to the input', back.mean, 'unit of the cloud', 'Mean distance from points of the result to the nearest input point');
        add('Distance from the input', there.mean, 'unit of the cloud', 'Mean distance from input points to the nearest point of the result. This distance is larger if the result has fewer points');
        add('Hausdorff distance', Math.max(there.max, back.max), 'unit of the cloud', 'The largest of all distances in both directions');
    }
    add('Time', Object.values(seconds || {}).reduce((sum, one) => sum + one, 0) || undefined, 's', 'Time from reading the input to writing the result');
    return all;
}

const fold = (title, ...content) => make('details', {}, make('summary', {}, title), ...content);

/** Fills the panel with a report, what matters first and the rest folded, or with a document that was asked for. */
export async function showReport(process, output, report) {
    const { inputs, outputs } = await describe(process).catch(() => ({ inputs: {}, outputs: {} })), { parameters, ...figures } = report;
    const first = output === 'report' ? headline(figures) : [], list = make('dl', {}, ...rows(figures, outputs[output]?.schema));
    const warnings = (figures.warnings || []).map(({ says }) => make('p', {}, `Warning: ${says}.`));
    $('report').replaceChildren(...warnings, ...(first.length ? [make('dl', {}, ...first), fold('All figures', list)] : [list]));
    if (parameters) $('report').append(fold('Parameters used', make('dl', {}, ...rows(parameters, meanings(inputs)))));
}

/** One sentence about a result, as parts of a paragraph in which no figure is broken. */
export function summary(report) {
    if (typeof report.delta !== 'number') return [];
    const parts = [`δ ${brief(report.delta)}`];
    if (report.points) parts.unshift(`${figure(report.points.in)} → ${figure(report.points.out)} points`);
    if (ENDED[report.stopped]) parts.push(ENDED[report.stopped]);
    return parts.flatMap((part, k) => [k ? ' · ' : '', make('span', { className: 'whole' }, part)]);
}
