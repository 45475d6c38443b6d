/* The colours that figures are shown in, the same in the shader and in the histogram. */

/** What points are coloured by: the number that the shader has for it. */
export const MODES = { plain: 0, original: 1, spacing: 2, distance: 3, normals: 4 };

/* Five stops each, evenly apart. Spacings: too close violet, as the mean teal, too far orange to red; all of them are seen on light and on
 * dark, and by those who cannot tell red from green. Distances: from dark to light, as viridis has them. */
const DIVERGING = [[0.36, 0.18, 0.66], [0.34, 0.42, 0.84], [0.05, 0.58, 0.52], [0.93, 0.58, 0.10], [0.82, 0.16, 0.12]];
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
