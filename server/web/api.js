/* Requests to the daemon that sent this page; the key, which lives as long as the tab's session. */

import { forSession } from './keep.js';

export const ROOT = new URL('..', import.meta.url); /* this file is ROOT/assets/page.js */
const KEY = 'voronoid-key';
let refused = () => {};

export const getKey = () => forSession.get(KEY);
export const setKey = (key) => forSession.set(KEY, key);
/** What to do when the daemon wants a key, or another one. */
export const onRefused = (then) => { refused = then; };

/** A refusal in the daemon's words. */
export class Problem extends Error {
    constructor(body, status) {
        super(body.detail || body.title || `The daemon responded with ${status}.`);
        Object.assign(this, { title: body.title, status, errors: (body.errors || []).map((one) => ({ detail: body.detail, ...one })) });
        if (status === 401) refused();
    }
}

/** The headers of a request: those given, and the key if there is one. */
export const headers = (more = {}) => (getKey() ? { Authorization: `Bearer ${getKey()}`, ...more } : more);

const parse = (text) => {
    try {
        return JSON.parse(text);
    } catch {
        return {};
    }
};

/** Asks for a path under the root. Resolves to the Response if it is a success or 304, else rejects with a Problem.
 *  @param {string} path
 *  @param {{method?: string, more?: object, body?: BodyInit, signal?: AbortSignal}} options */
export async function ask(path, { method = 'GET', more = {}, body, signal } = {}) {
    const answer = await fetch(new URL(path, ROOT), { method, headers: headers(more), body, signal, cache: 'no-store' })
        .catch((error) => { throw error.name === 'AbortError' ? error : new Error('The daemon does not answer.'); });
    if (answer.ok || answer.status === 304) return answer;
    throw new Problem(parse(await answer.text()), answer.status);
}

export const askJson = async (path, options) => (await ask(path, { ...options, more: { Accept: 'application/json', ...options?.more } })).json();

/** Sends a file, or a form, with progress, which fetch does not tell. told(bytes sent, bytes in all). Resolves to the answer's JSON;
 *  aborted rejects with an AbortError. */
export function send(path, body, { told, signal, more = {} }) {
    return new Promise((resolve, reject) => {
        const request = new XMLHttpRequest();
        request.open('POST', new URL(path, ROOT));
        for (const [name, value] of Object.entries(headers(more))) request.setRequestHeader(name, value);
        request.upload.onprogress = (event) => told(event.loaded, event.total);
        request.onload = () => {
            const answer = parse(request.responseText);
            if (request.status < 300) resolve(answer);
            else reject(new Problem(answer, request.status));
        };
        request.onerror = () => reject(new Error('The connection to the daemon was lost.'));
        request.onabort = () => reject(new DOMException('The upload was cancelled.', 'AbortError'));
        signal.addEventListener('abort', () => request.abort());
        request.send(body);
    });
}
