/* A k-d tree of points: who is nearest, and how the surface lies around a point. Halves of equal size, so that a node needs no
 * bounds of its own; points in the order of the leaves, so that neighbours lie together in memory. */

const LEAF = 12; /* points of a leaf at most */

/* Moves the middle of index[low, high) by a coordinate to its place, smaller ones before it. */
function select(index, xyz, axis, low, high, middle) {
    for (let left = low, right = high - 1; left < right;) {
        const pivot = xyz[3 * index[(left + right) >> 1] + axis];
        let i = left, j = right;
        while (i <= j) {
            while (xyz[3 * index[i] + axis] < pivot) i++;
            while (xyz[3 * index[j] + axis] > pivot) j--;
            if (i > j) break;
            const swap = index[i];
            index[i++] = index[j];
            index[j--] = swap;
        }
        if (middle <= j) right = j;
        else if (middle >= i) left = i;
        else return;
    }
}

function widest(index, xyz, low, high) {
    let axis = 0, most = -1;
    for (let k = 0; k < 3; k++) {
        let least = Infinity, greatest = -Infinity;
        for (let i = low; i < high; i++) {
            const value = xyz[3 * index[i] + k];
            if (value < least) least = value;
            if (value > greatest) greatest = value;
        }
        if (greatest - least > most) [axis, most] = [k, greatest - least];
    }
    return axis;
}

/** A tree over n x 3 floats: {n, index (point of a place), xyz (by place), axes, splits, leaves: [low, high, ...]}. O(n log n). */
export function makeTree(xyz) {
    const n = xyz.length / 3, index = new Uint32Array(n), nodes = 4 * Math.ceil(n / LEAF) + 1, leaves = [];
    const [axes, splits] = [new Uint8Array(nodes), new Float32Array(nodes)];
    for (let i = 0; i < n; i++) index[i] = i;
    const part = (node, low, high) => {
        if (high - low <= LEAF) return leaves.push(low, high);
        const axis = widest(index, xyz, low, high), middle = (low + high) >> 1;
        select(index, xyz, axis, low, high, middle);
        axes[node] = axis;
        splits[node] = xyz[3 * index[middle] + axis];
        part(2 * node + 1, low, middle);
        part(2 * node + 2, middle, high);
        return 0;
    };
    part(0, 0, n);
    const own = new Float32Array(3 * n);
    for (let i = 0; i < n; i++) for (let k = 0; k < 3; k++) own[3 * i + k] = xyz[3 * index[i] + k];
    return { n, index, xyz: own, axes, splits, leaves };
}

/** The k nearest places to a point, itself among them if it is one: fills found (places) and squares (squared distances), nearest
 *  first, both k long; fewer points leave Infinity behind. */
export function nearest(tree, x, y, z, found, squares) {
    const k = squares.length, point = [x, y, z], { xyz, axes, splits } = tree;
    squares.fill(Infinity);
    const look = (node, low, high) => {
        if (high - low > LEAF) {
            const middle = (low + high) >> 1, off = point[axes[node]] - splits[node];
            if (off < 0) look(2 * node + 1, low, middle);
            else look(2 * node + 2, middle, high);
            if (off * off >= squares[k - 1]) return;
            if (off < 0) look(2 * node + 2, middle, high);
            else look(2 * node + 1, low, middle);
            return;
        }
        for (let i = low; i < high; i++) {
            const dx = xyz[3 * i] - x, dy = xyz[3 * i + 1] - y, dz = xyz[3 * i + 2] - z, square = dx * dx + dy * dy + dz * dz;
            if (square >= squares[k - 1]) continue;
            let at = k - 1;
            for (; at > 0 && squares[at - 1] > square; at--) {
                squares[at] = squares[at - 1];
                found[at] = found[at - 1];
            }
            squares[at] = square;
            found[at] = i;
        }
    };
    look(0, 0, tree.n);
}

/** The direction in which places spread least, into to at row i; the sums are taken about their mean. */
export function leastSpread(tree, places, count, to, i) {
    const { xyz } = tree, mean = [0, 0, 0];
    let xx = 0, xy = 0, xz = 0, yy = 0, yz = 0, zz = 0;
    for (let k = 0; k < count; k++) for (let axis = 0; axis < 3; axis++) mean[axis] += xyz[3 * places[k] + axis] / count;
    for (let k = 0; k < count; k++) {
        const x = xyz[3 * places[k]] - mean[0], y = xyz[3 * places[k] + 1] - mean[1], z = xyz[3 * places[k] + 2] - mean[2];
        xx += x * x; xy += x * y; xz += x * z; yy += y * y; yz += y * z; zz += z * z;
    }
    /* The largest of the minors of two axes tells along which of them the normal is safest to write down. */
    const dx = yy * zz - yz * yz, dy = xx * zz - xz * xz, dz = xx * yy - xy * xy;
    let normal = [xy * yz - xz * yy, xy * xz - yz * xx, dz];
    if (dx >= dy && dx >= dz) normal = [dx, xz * yz - xy * zz, xy * yz - xz * yy];
    else if (dy >= dz) normal = [xz * yz - xy * zz, dy, xy * xz - yz * xx];
    const length = Math.hypot(...normal);
    for (let axis = 0; axis < 3; axis++) to[3 * i + axis] = length > 0 ? normal[axis] / length : +(axis === 2);
}
