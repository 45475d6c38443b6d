/* The colours that figures are shown in, the same in the shader and in the histogram. */

/** What points are coloured by: the number that the shader has for it. */
export const MODES = { plain: 0, original: 1, spacing: 2, distance: 3, normals: 4 };

/* Five stops each, evenly apart: below the middle blue, above it red; and from dark to light, as viridis has them. */
const DIVERGING = [[0.13, 0.35, 0.75], [0.48, 0.68, 0.90], [0.86, 0.86, 0.84], [0.95, 0.60, 0.40], [0.75, 0.12, 0.15]];
const RISING = [[0.27, 0.00, 0.33], [0.23, 0.32, 0.55], [0.13, 0.57, 0.55], [0.37, 0.79, 0.38], [0.99, 0.91, 0.14]];

export function stops(mode) {
    return mode === 'distance' ? RISING : DIVERGING;
}

/** The colour of t in [0, 1] as CSS has it. */
export function colorAt(mode, t) {
    const all = stops(mode), at = Math.min(Math.max(t, 0), 1) * (all.length - 1), low = Math.min(Math.floor(at), all.length - 2);
    const mixed = all[low].map((value, k) => Math.round(255 * (value + (all[low + 1][k] - value) * (at - low))));
    return `rgb(${mixed.join(', ')})`;
}
