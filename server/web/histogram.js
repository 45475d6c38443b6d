/* How often which figure occurs among the points, in the colours that they have in the view. */
import { count, figure } from './dom.js';
import { colorAt } from './palette.js';
import { color } from './theme.js';

const BINS = 60, TICKS = 14; /* pixels of figures below the bars */
const GAP = 16;              /* pixels between two histograms */

/** What the colours of a mode go from and to. Spacings are shown over their mean; distances up to one that 99 of 100 are below. */
export function rangeOf(mode, values, mean) {
    if (mode === 'spacing') return { low: 0.5 * mean, high: 1.5 * mean, unit: mean };
    const sorted = Float32Array.from(values).sort();
    return { low: 0, high: sorted[Math.floor(0.99 * (sorted.length - 1))] || 1, unit: 1 };
}

/** How much spacings vary, as the daemon defines delta: their standard deviation over their mean; NaN where all points coincide. */
export function deltaOf(values, mean) {
    let sum = 0;
    for (const value of values) sum += (value / mean - 1) ** 2;
    return Math.sqrt(sum / values.length);
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

function drawTicks(pen, { figures, low, high, unit }, width, height) {
    pen.font = '11px system-ui, sans-serif';
    pen.fillStyle = color('soft');
    [[low, 'left', 0], [(low + high) / 2, 'center', width / 2], [high, 'right', width]].forEach(([value, align, x], k) => {
        pen.textAlign = align;
        pen.fillText(`${k === 2 ? '≥ ' : ''}${!k && figures === 'spacing' ? '≤ ' : ''}${figure(value / unit)}`, x, height - 2);
    });
}

/* One histogram; the other cloud's, if there is one, is a line before the bars. */
function drawOne(pen, { one, other }, width, height) {
    const shares = sharesOf(one), others = other && sharesOf(other), top = height - TICKS;
    const most = [...shares, ...others || []].reduce((a, b) => Math.max(a, b), 0) || 1;
    shares.forEach((share, k) => {
        pen.fillStyle = one.isShown ? colorAt(one.figures, (k + 0.5) / BINS) : color('point');
        pen.fillRect(k * width / BINS, top * (1 - share / most), width / BINS - 1, top * share / most);
    });
    pen.strokeStyle = color('line');
    pen.strokeRect(0, top, width, 0);
    pen.strokeStyle = color('ink');
    pen.lineWidth = 1.5;
    if (others) outline(pen, others, most, width, top);
    drawTicks(pen, one, width, height);
}

const words = ({ whose, values, delta, high, figures }) => `${whose}: ${count(values.length)} points, ${figures === 'spacing'
    ? `δ ${figure(delta)}` : `from 0 to ${figure(high)} and more`}`;

/** Draws one histogram for each of panels ({one, other or null}) beside each other, with a sentence in the caption. One is {figures:
 *  'spacing' or 'distance', values, low, high, unit, whose, delta, isShown: whether the view has its colours}. */
export function drawHistogram(canvas, caption, panels) {
    const ratio = window.devicePixelRatio || 1, pen = canvas.getContext('2d'), width = canvas.clientWidth, height = canvas.clientHeight;
    const each = (width - GAP * (panels.length - 1)) / panels.length;
    [canvas.width, canvas.height] = [width * ratio, height * ratio];
    panels.forEach((panel, k) => {
        pen.setTransform(ratio, 0, 0, ratio, k * (each + GAP) * ratio, 0);
        drawOne(pen, panel, each, height);
    });
    const shown = panels.flatMap(({ one, other }) => [one, other].filter(Boolean));
    canvas.setAttribute('aria-label', shown.map(words).join('; '));
    caption.textContent = shown[0].figures === 'spacing'
        ? `Distance from each point to its nearest neighbour, divided by the mean distance. Evenly spread points have one narrow peak at 1.${panels[0].other ? ` Bars: ${panels[0].one.whose}, line: ${panels[0].other.whose}.` : ''}`
        : 'Distance from each point of the result to the nearest point of the input, in the unit of the cloud.';
}
