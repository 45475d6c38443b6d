/* From the form to a job: sends the file once, with its progress, or names the job that has it already. */
import { askJson, send } from './api.js';
import { $, bytes, show } from './dom.js';
import { query } from './query.js';

const ASYNC = { Prefer: 'respond-async' };

/* A file alone is the body; several are a form, whose main one may be the input of another job. */
function bodyOf(main, files) {
    const form = new FormData();
    if (main) form.append('file', main);
    Object.entries(files).forEach(([name, file]) => form.append(name, file));
    return Object.keys(files).length ? form : main;
}

async function upload(path, body) {
    const control = new AbortController(), cancel = () => control.abort();
    $('upload-cancel').addEventListener('click', cancel);
    $('upload-bar').value = 0;
    $('upload-words').textContent = '';
    show($('upload'), true);
    try {
        return await send(path, body, { more: ASYNC, signal: control.signal, told(sent, all) {
            $('upload-bar').value = all ? sent / all : 1;
            $('upload-words').textContent = sent < all ? `${bytes(sent)} of ${bytes(all)}` : 'The daemon is reading the file.';
        } });
    } finally {
        $('upload-cancel').removeEventListener('click', cancel);
        show($('upload'), false);
    }
}

/** Starts a job. source: {file, name, job}: job has the file as its input, so that it need not be sent again. files: those besides it,
 *  by name. Resolves to the job's status; rejects with a Problem, or an AbortError when the upload was cancelled. */
export async function startJob(process, values, source, files = {}) {
    const path = (more) => `v1/${process}?${query({ name: source.name, ...values, ...more })}`;
    if (source.job) {
        try {
            const again = path({ input: `job:${source.job}` }), body = bodyOf(null, files);
            return await (body ? upload(again, body) : askJson(again, { method: 'POST', more: ASYNC }));
        } catch (problem) {
            if (!source.file || ![404, 410].includes(problem.status)) throw problem; /* else: its bytes are gone by now */
        }
    }
    return upload(path({}), bodyOf(source.file, files));
}
