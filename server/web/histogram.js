/* How often which figure occurs among the points, in the colours that they have in the view. */
import { count, figure } from './dom.js';
import { colorAt } from './palette.js';
import { color } from './theme.js';

const BINS = 60, TICKS = 14; /* pixels of figures below the bars */

/** What the colours of a mode go from and to. Spacings are shown over their mean; distances up to one that 99 of 100 are below. */
export function rangeOf(mode, values, mean) {
    if (mode === 'spacing') return { low: 0.5 * mean, high: 1.5 * mean, unit: mean };
    const sorted = Float32Array.from(values).sort();
    return { low: 0, high: sorted[Math.floor(0.99 * (sorted.length - 1))] || 1, unit: 1 };
}

/* Shares of the values in each bin. */
function sharesOf({ values, low, high }) {
    const bins = new Float64Array(BINS);
    for (const value of values) bins[Math.min(BINS - 1, Math.max(0, Math.floor((value - low) / (high - low) * BINS)))] += 1 / values.length;
    return bins;
}

function outline(pen, shares, most, width, height) {
    pen.beginPath();
    shares.forEach((share, k) => [k, k + 1].forEach((x) => pen.lineTo(x * width / BINS, Math.min(height - 0.5, height * (1 - share / most) + 0.5))));
    pen.stroke();
}

function drawTicks(pen, { mode, low, high, unit }, width, height) {
    pen.font = '11px system-ui, sans-serif';
    pen.fillStyle = color('soft');
    [[low, 'left', 0], [(low + high) / 2, 'center', width / 2], [high, 'right', width]].forEach(([value, align, x], k) => {
        pen.textAlign = align;
        pen.fillText(`${k === 2 ? '≥ ' : ''}${!k && mode === 'spacing' ? '≤ ' : ''}${figure(value / unit)}`, x, height - 2);
    });
}

/** Draws it into a canvas, with a sentence in the caption. Figures of the other cloud, if there are any, are a line before the bars. */
export function drawHistogram(canvas, caption, one, other) {
    const { mode, values, low, high, unit, whose } = one, shares = sharesOf(one), others = other && sharesOf(other);
    const ratio = window.devicePixelRatio || 1, pen = canvas.getContext('2d'), width = canvas.clientWidth, height = canvas.clientHeight - TICKS;
    const most = [...shares, ...others || []].reduce((a, b) => Math.max(a, b), 0) || 1;
    [canvas.width, canvas.height] = [width * ratio, canvas.clientHeight * ratio];
    pen.scale(ratio, ratio);
    shares.forEach((share, k) => {
        pen.fillStyle = colorAt(mode, (k + 0.5) / BINS);
        pen.fillRect(k * width / BINS, height * (1 - share / most), width / BINS - 1, height * share / most);
    });
    pen.strokeStyle = color('soft'); /* the middle of the colours is as pale as the page */
    outline(pen, shares, most, width, height);
    pen.strokeStyle = color('accent');
    pen.lineWidth = 1.5;
    if (others) outline(pen, others, most, width, height);
    drawTicks(pen, one, width, canvas.clientHeight);
    const [from, to] = [figure(low / unit), figure(high / unit)];
    const also = other ? `. The line: ${other.whose}, over its mean, ${figure(other.unit)}` : '';
    caption.textContent = mode === 'spacing'
        ? `${whose}: distance to the nearest point over its mean, ${figure(unit)}, from ${from} (and less) to ${to} (and more); ${count(values.length)} points${also}`
        : `${whose}: distance to the nearest point of the input, from ${from} to ${to} (and more), in its unit; ${count(values.length)} points`;
}
