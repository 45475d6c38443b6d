/* The page's side of the worker that reads clouds. */

const waiting = new Map();
let calls = 0, numbers = 0, worker = null;

function start() {
    worker = new Worker(new URL('cloud_worker.js', import.meta.url));
    worker.onmessage = ({ data }) => {
        const { resolve, reject } = waiting.get(data.call);
        waiting.delete(data.call);
        if (data.error) reject(new Error(data.error));
        else resolve(data.answer);
    };
    /* A worker that ends, for want of memory say, answers nobody. */
    worker.onerror = () => {
        waiting.forEach(({ reject }) => reject(new Error('This cloud is too large for the memory of the browser.')));
        waiting.clear();
        worker = null;
    };
}

function ask(what, details, transfer = []) {
    if (!worker) start();
    return new Promise((resolve, reject) => {
        waiting.set(++calls, { resolve, reject });
        worker.postMessage({ call: calls, what, ...details }, transfer);
    });
}

/** Reads the bytes of a PLY, which are given away. origin: [x, y, z] that another cloud was read with, so that the two lie in one
 *  frame. Rejects with a sentence. The cloud that comes is what readPly returns, with a number. */
export async function readCloud(buffer, origin) {
    const number = ++numbers, cloud = await ask('read', { number, buffer, origin }, [buffer]);
    return { ...cloud, number };
}

/** What is measured once and kept in the cloud: each resolves to it. */
export const measures = {
    /* {normals, widths}: fitted ones; how wide each point is drawn. */
    surface: async (cloud) => (cloud.surface ||= await ask('normals', { number: cloud.number })),
    spacing: async (cloud) => (cloud.spacing ||= await ask('spacing', { number: cloud.number })),
    distance: async (cloud, to) => (cloud.distance ||= await ask('distance', { number: cloud.number, to: to.number })),
};

/** Lets the worker forget a cloud. */
export function dropCloud(cloud) {
    if (cloud) ask('drop', { number: cloud.number }).catch(() => {});
}
