/* Reads PLY files, ASCII or binary, for the preview. A cloud far from zero (metres of a map grid, say) would turn into stairs in
 * float32: positions are read as doubles, and the origin is subtracted before they are rounded. */

const READERS = {
    char: ['getInt8', 1], int8: ['getInt8', 1], uchar: ['getUint8', 1], uint8: ['getUint8', 1],
    short: ['getInt16', 2], int16: ['getInt16', 2], ushort: ['getUint16', 2], uint16: ['getUint16', 2],
    int: ['getInt32', 4], int32: ['getInt32', 4], uint: ['getUint32', 4], uint32: ['getUint32', 4],
    float: ['getFloat32', 4], float32: ['getFloat32', 4], double: ['getFloat64', 8], float64: ['getFloat64', 8],
};
const HEADER_BYTES_MAX = 65536;
/* What a whole number of a type stands for full colour by; of floats 1 does. */
const FULL = { uchar: 255, uint8: 255, ushort: 65535, uint16: 65535, float: 1, float32: 1, double: 1, float64: 1 };

function type(name) {
    if (!READERS[name]) throw new Error(`PLY has no type "${name}".`);
    return name;
}

function property(words) {
    return words[1] === 'list' ? { name: words[4], count: type(words[2]), type: type(words[3]) }
        : { name: words[2], type: type(words[1]) };
}

/* How others name what is drawn, in capitals too; the first spelling is the one used here. */
const SPELLINGS = [
    [['x', 'y', 'z']],
    [['nx', 'ny', 'nz'], ['normal_x', 'normal_y', 'normal_z']],
    [['red', 'green', 'blue'], ['diffuse_red', 'diffuse_green', 'diffuse_blue'], ['r', 'g', 'b']],
];

/* Gives scalars of another spelling the names used here, unless one has these already. */
function respell(properties) {
    const scalars = properties.filter((one) => !one.count);
    const find = (name) => scalars.find((one) => one.name === name) ?? scalars.find((one) => one.name.toLowerCase() === name);
    for (const spellings of SPELLINGS)
        for (const names of spellings) {
            const found = names.map(find);
            if (found.every(Boolean)) found.forEach((one, k) => { one.name = spellings[0][k]; });
            if (found.some(Boolean)) break;
        }
}

/** Reads the header: {format, elements: [{name, count, properties}], length}. Throws an Error with a sentence. */
export function readHeader(bytes) {
    const text = new TextDecoder('latin1').decode(bytes.subarray(0, HEADER_BYTES_MAX));
    const end = /(^|\n)end_header[ \t]*\r?\n/.exec(text);
    if (!/^(\xef\xbb\xbf)?ply[ \t]*\r?\n/.test(text) || !end) throw new Error('This is not a PLY file.');
    const head = { format: '', elements: [], length: end.index + end[0].length };
    for (const line of text.slice(0, end.index).split('\n')) {
        const words = line.trim().split(/\s+/);
        if (words[0] === 'format') head.format = words[1];
        if (words[0] === 'element') head.elements.push({ name: words[1]?.toLowerCase(), count: Number(words[2]), properties: [] });
        if (words[0] === 'property' && head.elements.length) head.elements.at(-1).properties.push(property(words));
    }
    head.elements.forEach((element) => respell(element.properties));
    return head;
}

/* A function that gives the next number of a type. That of a binary file has table(element, sinks), which reads all rows of an element
 * without lists, a property at a time: half the time of reading 2 M points. */
function numbers(buffer, head) {
    if (head.format === 'ascii') return words(new Uint8Array(buffer), head.length);
    const view = new DataView(buffer), little = head.format === 'binary_little_endian';
    let at = head.length;
    const next = (name) => {
        const [get, size] = READERS[name];
        at += size;
        return view[get](at - size, little);
    };
    next.table = ({ properties, count }, sinks) => {
        const stride = properties.reduce((sum, one) => sum + READERS[one.type][1], 0);
        if (at + stride * count > buffer.byteLength) throw new RangeError('The file ends too early.');
        properties.forEach((one, k) => {
            const [get, size] = READERS[one.type];
            if (sinks[k]) readColumn(view, get, little, { at, stride, count }, sinks[k]);
            at += size;
        });
        at += stride * (count - 1);
    };
    return next;
}

function readColumn(view, get, little, { at, stride, count }, { to, place, full }) {
    if (full !== 1) for (let i = 0; i < count; i++) to[3 * i + place] = Math.round(view[get](at + stride * i, little) * full);
    else for (let i = 0; i < count; i++) to[3 * i + place] = view[get](at + stride * i, little);
}

function words(bytes, at) {
    return () => {
        while (at < bytes.length && bytes[at] <= 32) at++;
        const begin = at;
        while (at < bytes.length && bytes[at] > 32) at++;
        if (begin === at) throw new RangeError('The file ends too early.');
        return Number(String.fromCharCode.apply(null, bytes.subarray(begin, at)));
    };
}

function skipList(next, property) {
    for (let left = next(property.count); left > 0; left--) next(property.type);
}

/* What becomes of each property of a vertex: null, or row i of an array has it at a place, times what makes it full (and whole). */
function sinks(element, into) {
    const axis = { x: 0, y: 1, z: 2, nx: 3, ny: 4, nz: 5, red: 6, green: 7, blue: 8 };
    const has = (...names) => names.every((name) => element.properties.some((one) => one.name === name));
    if (!has('x', 'y', 'z')) throw new Error('The vertices have no x, y and z.');
    into.xyz = new Float64Array(3 * element.count);
    into.normals = has('nx', 'ny', 'nz') ? new Float32Array(3 * element.count) : null;
    into.colors = has('red', 'green', 'blue') ? new Uint8Array(3 * element.count) : null;
    return element.properties.map((one) => {
        const column = axis[one.name], to = [into.xyz, into.normals, into.colors][Math.floor(column / 3)];
        if (one.count || !to) return null;
        return { to, place: column % 3, full: to === into.colors ? 255 / (FULL[one.type] || 255) : 1 };
    });
}

function readVertices(next, element, into) {
    const sink = sinks(element, into), { properties } = element;
    if (next.table && element.count && !properties.some((one) => one.count)) return next.table(element, sink);
    for (let i = 0; i < element.count; i++)
        for (let k = 0; k < properties.length; k++) {
            if (properties[k].count) skipList(next, properties[k]);
            else {
                const value = next(properties[k].type), { to, place, full } = sink[k] || {};
                if (to) to[3 * i + place] = full === 1 ? value : Math.round(value * full);
            }
        }
    return undefined;
}

/* Faces as fans of triangles. */
function readFaces(next, element, into) {
    const corners = [];
    for (let i = 0; i < element.count; i++)
        for (const one of element.properties) {
            if (!one.count) next(one.type);
            else if (!/^vertex_ind/.test(one.name)) skipList(next, one);
            else {
                const n = next(one.count), first = next(one.type);
                for (let k = 1, last = n > 1 ? next(one.type) : 0; k + 1 < n; k++) {
                    const corner = next(one.type);
                    corners.push(first, last, corner);
                    last = corner;
                }
            }
        }
    into.faces = corners.length ? Uint32Array.from(corners) : null;
}

function skipElement(next, element) {
    for (let i = 0; i < element.count; i++)
        for (const one of element.properties)
            if (one.count) skipList(next, one);
            else next(one.type);
}

/* Leaves out points that are not finite, and the triangles that hang on them. */
function sift(cloud) {
    if (cloud.xyz.every(Number.isFinite)) return;
    const n = cloud.xyz.length / 3, place = new Int32Array(n).fill(-1);
    let kept = 0;
    for (let i = 0; i < n; i++) {
        if (!Number.isFinite(cloud.xyz[3 * i] + cloud.xyz[3 * i + 1] + cloud.xyz[3 * i + 2])) continue;
        for (const rows of [cloud.xyz, cloud.normals, cloud.colors])
            if (rows) rows.copyWithin(3 * kept, 3 * i, 3 * i + 3);
        place[i] = kept++;
    }
    for (const name of ['xyz', 'normals', 'colors']) if (cloud[name]) cloud[name] = cloud[name].slice(0, 3 * kept);
    const whole = [];
    for (let i = 0; cloud.faces && i < cloud.faces.length; i += 3) {
        const corner = [0, 1, 2].map((k) => place[cloud.faces[i + k]]);
        if (Math.min(...corner) >= 0) whole.push(...corner);
    }
    cloud.faces = whole.length ? Uint32Array.from(whole) : null;
    cloud.left = n - kept;
}

function bounds(xyz) {
    const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
    for (let k = 0; k < 3; k++)
        for (let i = k; i < xyz.length; i += 3) {
            if (xyz[i] < low[k]) low[k] = xyz[i];
            if (xyz[i] > high[k]) high[k] = xyz[i];
        }
    return { low, high };
}

/** The first points of a binary file that is still coming, as a file of its own; null as long as fewer than n of them are there, or
 *  where they do not come first. Of a cloud in progressive order they are all of it, coarsely. */
export function firstOf(bytes, n) {
    const head = readHeader(bytes), [element] = head.elements;
    if (head.format === 'ascii' || element?.name !== 'vertex' || element.count <= n || element.properties.some((one) => one.count)) return null;
    const size = n * element.properties.reduce((sum, one) => sum + READERS[one.type][1], 0);
    if (bytes.length < head.length + size) return null;
    const names = element.properties.map((one) => `property ${one.type} ${one.name}`);
    const text = new TextEncoder().encode(['ply', `format ${head.format} 1.0`, `element vertex ${n}`, ...names, 'end_header', ''].join('\n'));
    const out = new Uint8Array(text.length + size);
    out.set(text);
    out.set(bytes.subarray(head.length, head.length + size), text.length);
    return out.buffer;
}

/** Reads a cloud. origin: [x, y, z] to subtract; not given, the middle of the cloud.
 *  Returns n, positions (float32, relative), origin, low, high (relative), normals, colors, faces (or null), left (out, not finite).
 *  Throws an Error with a sentence when the bytes are no whole PLY. */
export function readPly(buffer, origin) {
    const head = readHeader(new Uint8Array(buffer)), next = numbers(buffer, head);
    const cloud = { xyz: null, normals: null, colors: null, faces: null, left: 0 };
    if (!/^(ascii|binary_(little|big)_endian)$/.test(head.format)) throw new Error(`PLY has no format "${head.format}", want ascii, binary_little_endian or binary_big_endian.`);
    try {
        for (const element of head.elements) {
            if (element.name === 'vertex') readVertices(next, element, cloud);
            else if (element.name === 'face') readFaces(next, element, cloud);
            else skipElement(next, element);
        }
    } catch (error) {
        throw error instanceof RangeError ? new Error('The file ends before its last row.') : error;
    }
    if (!cloud.xyz) throw new Error('The file has no vertices.');
    if (cloud.faces?.some((corner) => 3 * corner >= cloud.xyz.length)) throw new Error('A face refers to a vertex that does not exist.');
    sift(cloud);
    const { low, high } = bounds(cloud.xyz);
    const from = origin || low.map((value, k) => (value + high[k]) / 2 || 0);
    const positions = new Float32Array(cloud.xyz.length);
    for (let k = 0; k < 3; k++) for (let i = k; i < positions.length; i += 3) positions[i] = cloud.xyz[i] - from[k];
    return { n: positions.length / 3, positions, origin: from, low: low.map((value, k) => value - from[k]),
        high: high.map((value, k) => value - from[k]), normals: cloud.normals, colors: cloud.colors, faces: cloud.faces,
        left: cloud.left };
}
