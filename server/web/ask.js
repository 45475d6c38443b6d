/* What is asked for: a process the daemon lists, and its parameters. */
import { askJson } from './api.js';
import { $, make, show } from './dom.js';
import { makeForm } from './form.js';

const forms = new Map();

/** The process chosen and its values that differ from the defaults. */
export const asked = () => ({ process: $('process').value, values: forms.get($('process').value)?.values() || {} });

export const blame = (errors) => forms.get($('process').value)?.blame(errors);

/** Chooses a process, and the values of its form where they are given. */
export function choose(process, values) {
    const form = forms.get(process);
    if (!form) return;
    $('process').value = process;
    if (values) form.set(values);
    $('process-words').textContent = $('process').selectedOptions[0].dataset.words;
    $('fields').replaceChildren(...form.elements);
}

function showPresets(presets) {
    show($('presets'), presets.length > 0);
    $('presets').replaceChildren(...presets.map((preset) => {
        const button = make('button', { type: 'button', title: preset.description }, preset.title);
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
        return option;
    }));
    showPresets(descriptions.flatMap((one) => (one['x-presets'] || []).map((preset) => ({ process: one.id, ...preset }))));
    choose(processes[0].id);
}

$('process').addEventListener('change', () => choose($('process').value));
