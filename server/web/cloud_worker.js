/* The worker that reads clouds and measures them, so that the page never stands still. It keeps each cloud's tree by the number
 * that the page gave it. */
import { readPly } from './ply.js';
import { leastSpread, makeTree, nearest } from './tree.js';

const NORMAL_NEIGHBORS = 10;
/* Of more points than these normals are those of leaves of the tree: coarser, and ten times as fast. */
const NORMALS_EACH_MAX = 400000;
const SLICE_MS = 30; /* of measuring, between which other clouds are read: the first points of a result are not to wait for those of its input */
const clouds = new Map();

function tree(number) {
    const cloud = clouds.get(number);
    if (!cloud) throw new Error('The cloud was removed.');
    cloud.tree = cloud.tree || makeTree(cloud.positions);
    return cloud.tree;
}

const pause = new MessageChannel(), paused = [];
pause.port2.onmessage = () => paused.shift()();
const breath = () => new Promise((resolve) => {
    paused.push(resolve);
    pause.port1.postMessage(0);
});

/* Works on 0 to n - 1 in slices, as long as the cloud is there. */
async function each(number, n, work) {
    for (let i = 0, end = performance.now() + SLICE_MS; i < n; i++) {
        work(i);
        if (i % 256 || performance.now() < end) continue;
        await breath();
        if (!clouds.has(number)) throw new Error('The cloud was removed.');
        end = performance.now() + SLICE_MS;
    }
}

function read({ number, buffer, origin }) {
    const cloud = readPly(buffer, origin);
    clouds.set(number, { positions: cloud.positions.slice() });
    return cloud;
}

/* A disc as wide as the distance to the sixth neighbour, times 1.2 or more, reaches the discs around it: in an even cloud these are the
 * six at the spacing, along the lines of a scanner they are those of the next line too. */
const RING = 6;
/* Times the mean: a point with a longer way to others stands alone, as those of trees do, and a disc that wide would be a blob (seen at
 * 2.5, while at 1.3 scans show the ground between their lines); one with a shorter way coincides with others. */
const [NARROWEST, WIDEST] = [0.4, 1.6];
const POISSON_RING = Math.sqrt(RING / Math.PI); /* where the sixth neighbour is, over the root of the area of a point */

function clampWidths(widths) {
    let sum = 0;
    for (let i = 0; i < widths.length; i++) sum += widths[i];
    const mean = sum / widths.length;
    for (let i = 0; i < widths.length; i++) widths[i] = Math.min(Math.max(widths[i], NARROWEST * mean), WIDEST * mean);
    return widths;
}

/* Of the points of a leaf, by the area of their box. */
function leafWidth(here, low, high) {
    const sides = [0, 1, 2].map((axis) => {
        let [least, most] = [Infinity, -Infinity];
        for (let k = low; k < high; k++) {
            least = Math.min(least, here.xyz[3 * k + axis]);
            most = Math.max(most, here.xyz[3 * k + axis]);
        }
        return most - least;
    }).sort((a, b) => b - a);
    return POISSON_RING * Math.sqrt(sides[0] * sides[1] / (high - low));
}

/* Normals, without a side, and how wide a disc each point is drawn with. */
async function normals({ number }) {
    const here = tree(number), out = new Float32Array(3 * here.n), widths = new Float32Array(here.n);
    const found = new Uint32Array(NORMAL_NEIGHBORS), squares = new Float64Array(NORMAL_NEIGHBORS);
    if (here.n > NORMALS_EACH_MAX) {
        await each(number, here.leaves.length / 2, (k) => {
            const [low, high] = [here.leaves[2 * k], here.leaves[2 * k + 1]], places = Array.from({ length: high - low }, (_, i) => low + i);
            leastSpread(here, places, places.length, out, here.index[low]);
            const first = 3 * here.index[low], width = leafWidth(here, low, high);
            for (const place of places) {
                out.copyWithin(3 * here.index[place], first, first + 3);
                widths[here.index[place]] = width;
            }
        });
        return { normals: out, widths: clampWidths(widths) };
    }
    await each(number, here.n, (i) => {
        nearest(here, here.xyz[3 * i], here.xyz[3 * i + 1], here.xyz[3 * i + 2], found, squares);
        leastSpread(here, found, Math.min(NORMAL_NEIGHBORS, here.n), out, here.index[i]);
        widths[here.index[i]] = Math.sqrt(squares[Math.min(RING, here.n - 1)]);
    });
    return { normals: out, widths: clampWidths(widths) };
}

async function spacing({ number }) {
    const here = tree(number), values = new Float32Array(here.n);
    const found = new Uint32Array(2), squares = new Float64Array(2);
    let sum = 0;
    await each(number, here.n, (i) => {
        nearest(here, here.xyz[3 * i], here.xyz[3 * i + 1], here.xyz[3 * i + 2], found, squares);
        const distance = Number.isFinite(squares[1]) ? Math.sqrt(squares[1]) : 0;
        values[here.index[i]] = distance;
        sum += distance;
    });
    return { values, mean: here.n ? sum / here.n : 0 };
}

async function distance({ number, to }) {
    const here = tree(number), there = tree(to), values = new Float32Array(here.n);
    const found = new Uint32Array(1), squares = new Float64Array(1);
    await each(number, here.n, (i) => {
        nearest(there, here.xyz[3 * i], here.xyz[3 * i + 1], here.xyz[3 * i + 2], found, squares);
        values[here.index[i]] = Math.sqrt(squares[0]);
    });
    return { values };
}

function drop({ number }) {
    clouds.delete(number);
    return {};
}

const OPERATIONS = { read, normals, spacing, distance, drop };

const worker = /** @type {any} */ (self); /* tsc takes it for a window */
worker.onmessage = async ({ data }) => {
    try {
        const answer = await OPERATIONS[data.what](data);
        const buffers = Object.values(answer).filter(ArrayBuffer.isView).map((array) => array.buffer);
        worker.postMessage({ call: data.call, answer }, buffers);
    } catch (error) {
        worker.postMessage({ call: data.call, error: error.message });
    }
};
