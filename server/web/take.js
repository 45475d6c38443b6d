/* What can be taken away: results, the records as a table, the picture, the request as a command. */
import { ROOT, ask, getKey } from './api.js';
import { asked } from './ask.js';
import { command } from './commands.js';
import { $, bytes, make } from './dom.js';

const ENDINGS = { ply: 'ply', draco: 'drc', json: 'json', las: 'las', laz: 'laz', e57: 'e57' };
let name = 'cloud';

const base = () => name.replace(/\.[^.]{1,5}$/, '') || 'cloud';

/** What files are called after: the input. */
export const setName = (input) => { name = input || 'cloud'; };

/** Hands bytes to the browser as a file. */
export function save(blob, ending, what = '') {
    const url = URL.createObjectURL(blob), link = make('a', { href: url, download: `${base()}${what && `.${what}`}.${ending}` });
    link.click();
    setTimeout(() => URL.revokeObjectURL(url), 60000);
}

/* A button that fetches, with the key where there is one, and saves. */
function taker(words, path, ending, what, options) {
    const button = make('button', { type: 'button' }, words);
    button.addEventListener('click', async () => {
        button.disabled = true;
        try {
            save(await (await ask(path, options)).blob(), ending, what);
        } catch (error) {
            $('trouble').textContent = error.message;
        }
        button.disabled = false;
    });
    return button;
}

function chartTaker() {
    const button = make('button', { type: 'button' }, 'Download chart (PNG)');
    button.addEventListener('click', () => $('chart').toBlob((blob) => save(blob, 'png', 'chart')));
    return button;
}

/** The buttons of a job that is over: its cloud, or where it has none its documents; others beside the report. */
export function showTakers(status) {
    const at = `v1/jobs/${status.jobID}`, items = status.links.filter((link) => link.rel === 'item'), buttons = [], others = [];
    for (const item of items) {
        const ending = ENDINGS[item.type.split('/')[1]] || 'bin', what = item.title === 'cloud' ? status.processID : item.title;
        if (item.title === 'cloud') {
            for (const format of ['ply', 'drc'])
                buttons.push(taker(`Download ${format === 'ply' ? 'PLY' : 'Draco'}`, `${at}/results/cloud?link=false&format=${format}`, format, status.processID));
        } else others.push(taker(`Download ${item.title} (${bytes(item.length)})`, `${at}/results/${item.title}?link=false`, ending, what));
    }
    if (items.some((item) => item.title === 'report'))
        others.push(taker('Download metrics (CSV)', `${at}/trace`, 'csv', 'metrics', { more: { Accept: 'text/csv' } }), chartTaker());
    $('takers').replaceChildren(...buttons.length ? buttons : others.splice(0));
    $('more-takers').replaceChildren(...others);
}

function request() {
    const { process, values, files } = asked(), ending = values.format === 'drc' ? 'drc' : 'ply';
    const others = Object.fromEntries(Object.entries(files).map(([input, file]) => [input, file.name]));
    return { root: ROOT, process, values, file: name, others, key: Boolean(getKey()),
        out: /^(measure|inspect)$/.test(process) ? `${base()}.${process}.json` : `${base()}.${process}.${ending}` };
}

/** Wires the buttons that copy the form as a command, which is shown as well: a clipboard may be shut. */
export function wireCommands() {
    $('commands').addEventListener('click', async (event) => {
        const { language } = /** @type {HTMLElement} */ (event.target).dataset;
        if (!language) return;
        const text = command(language, request());
        $('command').textContent = text;
        $('command').hidden = false;
        try {
            await navigator.clipboard.writeText(text);
            $('command-words').textContent = 'Copied.';
        } catch {
            $('command-words').textContent = 'The browser does not allow copying: select the text below.';
        }
    });
}
