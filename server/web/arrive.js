/* A large result in progressive order is shown coarsely while the rest of it comes. */
import { firstOf } from './ply.js';

const EARLY_POINTS = 200000;
const EARLY_BYTES = 16e6; /* of smaller results the rest is there before the first would be drawn */

/** The bytes of an answer. Those of a large PLY in progressive order: early(buffer of its first points) is called once. */
export async function arrive(answer, isProgressive, early) {
    const size = Number(answer.headers.get('Content-Length'));
    if (!isProgressive || !(size > EARLY_BYTES)) return answer.arrayBuffer();
    const bytes = new Uint8Array(size), reader = answer.body.getReader();
    for (let got = 0, told = false; ;) {
        const { done, value } = await reader.read();
        if (done) return bytes.buffer.slice(0, got);
        bytes.set(value, got);
        got += value.length;
        const first = told ? null : firstOf(bytes.subarray(0, got), EARLY_POINTS);
        if (first) early(first);
        told = told || Boolean(first);
    }
}
