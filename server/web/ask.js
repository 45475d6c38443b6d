/* What is asked for: a process the daemon lists, and its parameters. */
import { askJson } from './api.js';
import { $, make, show } from './dom.js';
import { makeForm } from './form.js';

const forms = new Map(), FORMATS = { 'application/ply': 'PLY', 'application/draco': 'Draco' };
let isMesh = false;

/** The process chosen, its values that differ from the defaults, and files besides the cloud. */
export function asked() {
    const process = $('process').value, form = forms.get(process);
    return { process, values: form?.values() || {}, files: form?.files() || {} };
}

export const blame = (errors) => forms.get($('process').value)?.blame(errors);

/** Chooses a process, and the values of its form where they are given. */
export function choose(process, values) {
    const form = forms.get(process);
    if (!form) return;
    $('process').value = process;
    if (values) form.set(values);
    $('process-words').textContent = $('process').selectedOptions[0].dataset.words;
    $('fields').replaceChildren(...form.elements);
    tell();
}

/* A mesh can be resampled as its vertices or as the surface of its faces, which a stranger would not look for in the form. */
function tell() {
    const sample = forms.get($('process').value)?.field('sample'), isFaces = sample?.read() === 'faces';
    show($('mesh-hint'), isMesh && Boolean(sample));
    $('mesh-words').textContent = isFaces ? 'This is a mesh. Points that are sampled from the faces are the input.' : 'This is a mesh. The vertices of the mesh are the input.';
    $('mesh-turn').textContent = isFaces ? 'Use its vertices' : 'Sample its faces';
    const { process, values } = asked(), is = JSON.stringify(Object.entries(values).sort());
    for (const one of /** @type {HTMLElement[]} */ ([...$('presets').children]))
        one.setAttribute('aria-pressed', String(one.dataset.process === process && one.dataset.values === is));
}

/** Says whether the cloud has faces. Of a new one that has none, none are taken because another's were. */
export function tellMesh(hasFaces, isNew) {
    isMesh = hasFaces;
    forms.forEach((form) => {
        if (hasFaces || !isNew || form.field('sample')?.read() !== 'faces') return;
        form.field('sample').write('');
        form.refresh();
    });
    tell();
}

const written = (values) => Object.fromEntries(Object.entries(values).map(([name, value]) => [name, String(value)]));

function showPresets(presets) {
    show($('presets'), presets.length > 0);
    $('presets').replaceChildren(...presets.map((preset) => {
        const button = make('button', { type: 'button', title: preset.description }, preset.title);
        Object.assign(button.dataset, { process: preset.process, values: JSON.stringify(Object.entries(written(preset.values)).sort()) });
        button.addEventListener('click', () => choose(preset.process, preset.values));
        return button;
    }));
}

/** Asks the daemon what it offers. */
export async function loadProcesses() {
    const { processes } = await askJson('v1/processes');
    const descriptions = await Promise.all(processes.map(({ id }) => askJson(`v1/processes/${id}`)));
    $('process').replaceChildren(...descriptions.map((one) => {
        const option = make('option', { value: one.id }, one.title);
        option.dataset.words = one.description;
        forms.set(one.id, makeForm(one));
        if (one['x-presets']?.length) forms.get(one.id).set(one['x-presets'][0].values); /* so that there is something to run */
        return option;
    }));
    showPresets(descriptions.flatMap((one) => (one['x-presets'] || []).map((preset) => ({ process: one.id, ...preset }))));
    const types = descriptions.flatMap((one) => (one.inputs.cloud?.schema.oneOf || []).map(({ contentMediaType }) => FORMATS[contentMediaType]));
    $('formats').textContent = `(${[...new Set(types)].filter(Boolean).join(', ')})`;
    choose(processes[0].id);
}

$('process').addEventListener('change', () => choose($('process').value));
$('fields').addEventListener('input', tell);
$('mesh-turn').addEventListener('click', () => {
    const form = forms.get($('process').value), sample = form.field('sample');
    sample.write(sample.read() === 'faces' ? '' : 'faces');
    form.refresh();
    tell();
});
