/* What is asked for: a process the daemon lists, and its parameters. */
import { askJson } from './api.js';
import { $, make, show } from './dom.js';
import { makeForm } from './form.js';

/* Processes that take one cloud by itself; where a description names no file at all, there is nothing to run it on. */
const forms = new Map();
let presets = [];

async function formOf(id) {
    if (!forms.has(id)) forms.set(id, makeForm(await askJson(`v1/processes/${id}`)));
    return forms.get(id);
}

/** The process chosen and its values that differ from the defaults. */
export const asked = () => ({ process: $('process').value, values: forms.get($('process').value)?.values() || {} });

export const blame = (errors) => forms.get($('process').value)?.blame(errors);

/** Chooses a process, and the values of its form where they are given. */
export async function choose(process, values) {
    if (![...$('process').options].some((option) => option.value === process)) return;
    $('process').value = process;
    const form = await formOf(process);
    if ($('process').value !== process) return;
    if (values) form.set(values);
    $('process-words').textContent = $('process').selectedOptions[0].dataset.words;
    $('fields').replaceChildren(...form.elements);
}

function showPresets() {
    show($('presets'), presets.length > 0);
    $('presets').replaceChildren(make('span', {}, 'Presets'), ...presets.map((preset) => {
        const button = make('button', { type: 'button', title: preset.description || '' }, preset.title || preset.name);
        button.addEventListener('click', () => choose(preset.process, preset.values));
        return button;
    }));
}

/** Asks the daemon what it offers. */
export async function loadProcesses() {
    const { processes } = await askJson('v1/processes');
    forms.clear();
    $('process').replaceChildren(...processes.map((one) => {
        const option = make('option', { value: one.id }, one.title || one.id);
        option.dataset.words = one.description || '';
        return option;
    }));
    presets = processes.flatMap((one) => (one.presets || []).map((preset) => ({ process: one.id, ...preset })));
    showPresets();
    await choose(processes[0].id);
}

$('process').addEventListener('change', () => choose($('process').value));
