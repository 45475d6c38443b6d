/* From the form to a job: sends the file once, with its progress, or names the job that has it already. */
import { askJson, send } from './api.js';
import { $, bytes, show } from './dom.js';
import { query } from './query.js';

const ASYNC = { Prefer: 'respond-async' };

async function upload(path, file) {
    const control = new AbortController(), cancel = () => control.abort();
    $('upload-cancel').addEventListener('click', cancel);
    $('upload-bar').value = 0;
    $('upload-words').textContent = '';
    show($('upload'), true);
    try {
        return await send(path, file, { more: ASYNC, signal: control.signal, told(sent, all) {
            $('upload-bar').value = all ? sent / all : 1;
            $('upload-words').textContent = sent < all ? `${bytes(sent)} of ${bytes(all)}` : 'The daemon reads it.';
        } });
    } finally {
        $('upload-cancel').removeEventListener('click', cancel);
        show($('upload'), false);
    }
}

/** Starts a job. source: {file, name, job}: job has the file as its input, so that it need not be sent again. Resolves to the job's
 *  status; rejects with a Problem, or an AbortError when the upload was cancelled. */
export async function startJob(process, values, source) {
    const path = (more) => `v1/${process}?${query({ name: source.name, ...values, ...more })}`;
    if (source.job) {
        try {
            return await askJson(path({ input: `job:${source.job}` }), { method: 'POST', more: ASYNC });
        } catch (problem) {
            if (!source.file || ![404, 410].includes(problem.status)) throw problem; /* else: its bytes are gone by now */
        }
    }
    return upload(path({}), source.file);
}
