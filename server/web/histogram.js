/* How often which figure occurs among the points, in the colours that they have in the view. */
import { count, figure } from './dom.js';
import { colorAt } from './palette.js';
import { color } from './theme.js';

const BINS = 60;

/** What the colours of a mode go from and to. Spacings are shown over their mean; distances up to one that 99 of 100 are below. */
export function rangeOf(mode, values, mean) {
    if (mode === 'spacing') return { low: 0.5 * mean, high: 1.5 * mean, unit: mean };
    const sorted = Float32Array.from(values).sort();
    return { low: 0, high: sorted[Math.floor(0.99 * (sorted.length - 1))] || 1, unit: 1 };
}

/** Draws it into a canvas, with a sentence in the caption. */
export function drawHistogram(canvas, caption, { mode, values, low, high, unit, whose }) {
    const bins = new Uint32Array(BINS), [width, height] = [canvas.clientWidth, canvas.clientHeight];
    const ratio = window.devicePixelRatio || 1, pen = canvas.getContext('2d');
    for (const value of values) bins[Math.min(BINS - 1, Math.max(0, Math.floor((value - low) / (high - low) * BINS)))]++;
    const most = bins.reduce((a, b) => Math.max(a, b), 1);
    [canvas.width, canvas.height] = [width * ratio, height * ratio];
    pen.scale(ratio, ratio);
    bins.forEach((n, k) => {
        pen.fillStyle = colorAt(mode, (k + 0.5) / BINS);
        pen.fillRect(k * width / BINS, height * (1 - n / most), width / BINS - 1, height * n / most);
    });
    pen.strokeStyle = color('soft'); /* the middle of the colours is as pale as the page */
    pen.beginPath();
    bins.forEach((n, k) => [k, k + 1].forEach((x) => pen.lineTo(x * width / BINS, Math.min(height - 0.5, height * (1 - n / most) + 0.5))));
    pen.stroke();
    const [from, to] = [figure(low / unit), figure(high / unit)];
    caption.textContent = mode === 'spacing'
        ? `${whose}: distance to the nearest point over its mean, ${figure(unit)}, from ${from} (and less) to ${to} (and more); ${count(values.length)} points`
        : `${whose}: distance to the nearest point of the input, from ${from} to ${to} (and more), in its unit; ${count(values.length)} points`;
}
