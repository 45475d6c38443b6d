/* A file comes by dropping it anywhere on the page, or by choosing it. */
import { $ } from './dom.js';

/** taken(File) is called for each. */
export function wireDrop(taken) {
    const isOther = ({ target }) => target instanceof HTMLInputElement && target.type === 'file' && target.id !== 'file'; /* takes it itself */
    const over = (event) => {
        if (isOther(event)) return;
        if (![...event.dataTransfer.types].includes('Files')) return;
        event.preventDefault();
        document.body.classList.add('over');
    };
    const out = () => document.body.classList.remove('over');
    document.addEventListener('dragenter', over);
    document.addEventListener('dragover', over);
    document.addEventListener('dragleave', (event) => event.relatedTarget || out());
    document.addEventListener('drop', (event) => {
        out();
        if (isOther(event) || !event.dataTransfer.files.length) return;
        event.preventDefault();
        taken(event.dataTransfer.files[0]);
    });
    $('file').addEventListener('change', () => {
        if ($('file').files.length) taken($('file').files[0]);
        $('file').value = ''; /* so that the same file can be chosen again */
    });
}

/** The first bytes say what a file is, whatever it is called. */
export async function isPly(file) {
    return /^ply\r?\n/.test(await file.slice(0, 5).text());
}
