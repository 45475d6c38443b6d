/* How even the result would be at each record, over the time of the run: the delta of the most even points so far, as the report says it of
 * the result. Points on their way may be less even for a moment; they are not handed back. */
import { brief, seconds } from './dom.js';
import { color } from './theme.js';

const LEFT = 52, LINE = 12; /* pixels: room for figures, for a line of names of stages or of times */
const STAGES = { iterate: 'iterations', project: 'projection', insert: 'insertion' }; /* others by their own names */
const RISE = 1.02; /* times that delta grows at the end of a run before this is explained */

const least = (values) => values.reduce((a, b) => Math.min(a, b), Infinity);
const greatest = (values) => values.reduce((a, b) => Math.max(a, b), -Infinity);
const deltaOf = (record) => record.best?.delta;

function scaleOf(values, top, height) {
    const shown = values.filter((value) => value > 0).map(Math.log), low = least(shown), span = greatest(shown) - low || 1;
    return (value) => top + height - (Math.log(Math.max(value, 1e-300)) - low) / span * height;
}

function curve(pen, rows, x, top, height, width) {
    const values = rows.map(deltaOf), y = scaleOf(values, top + 5, height - 10), [low, high] = [least(values), greatest(values)];
    pen.strokeStyle = color('line');
    pen.strokeRect(LEFT, top, width - LEFT - 1, height);
    pen.strokeStyle = pen.fillStyle = color('delta');
    pen.lineWidth = 1.5;
    pen.beginPath();
    rows.forEach((row, k) => (k ? pen.lineTo(x(row), y(values[k])) : pen.moveTo(x(row), y(values[k]))));
    pen.stroke();
    pen.beginPath();
    pen.arc(x(rows.at(-1)), y(values.at(-1)), 3, 0, 2 * Math.PI);
    pen.fill();
    pen.lineWidth = 1;
    pen.font = '600 13px system-ui, sans-serif';
    pen.fillText('δ', 2, top + height / 2 + 4);
    pen.font = '10px system-ui, sans-serif';
    pen.fillStyle = color('soft');
    pen.textAlign = 'right';
    pen.fillText(brief(high), LEFT - 4, top + 9);
    if (low < high) pen.fillText(brief(low), LEFT - 4, top + height - 1);
    pen.textAlign = 'left';
}

/* Where the names of stages go: {words, at, line, x}; on a second line those that would run into the one before, on none if there too. */
function places(pen, begins, x, width) {
    const until = [-Infinity, -Infinity];
    return begins.map((row) => {
        const words = STAGES[row.run_stage] || row.run_stage || '', long = pen.measureText(words).width;
        const at = Math.min(x(row) + 2, width - long), line = until.findIndex((end) => at >= end);
        if (line >= 0) until[line] = at + long + 4;
        return { words, at, line, x: x(row) };
    });
}

/* A line where another stage begins, with its name. Returns where the strips begin. */
function stages(pen, rows, x, width, height) {
    pen.font = '11px system-ui, sans-serif';
    pen.strokeStyle = color('line');
    pen.fillStyle = color('soft');
    const all = places(pen, rows.filter((row, k) => !k || row.run_stage !== rows[k - 1].run_stage), x, width);
    const top = 4 + LINE * Math.max(...all.map((one) => one.line + 1), 1);
    all.forEach((one) => {
        pen.strokeRect(one.x, top, 0, height - top);
        if (one.line >= 0) pen.fillText(one.words, one.at, LINE * (one.line + 1) - 1);
    });
    return top;
}

/* Why delta rises once the steps are over: then points are placed as they are handed back. */
function rise(rows, isMesh) {
    const [before, last] = rows.slice(-2);
    if (!last || last.step !== before.step || deltaOf(last) < RISE * deltaOf(before)) return '';
    return isMesh ? ' δ rises at the end, because points move a little to improve the triangles.'
        : ' δ rises at the end, because points are moved back onto the input.';
}

/** Draws records into a canvas, says in its label what is to be seen, and returns a sentence to stand below. */
export function drawChart(canvas, records, isMesh) {
    const rows = records.filter((row) => typeof deltaOf(row) === 'number');
    const ratio = window.devicePixelRatio || 1, [width, height] = [canvas.clientWidth, canvas.clientHeight], pen = canvas.getContext('2d');
    canvas.dataset.points = String(rows.length);
    if (!rows.length || !width) return '';
    [canvas.width, canvas.height] = [Math.round(width * ratio), Math.round(height * ratio)];
    pen.scale(ratio, ratio);
    const from = rows[0].seconds, span = rows.at(-1).seconds - from || 1, x = (row) => LEFT + 4 + (row.seconds - from) / span * (width - LEFT - 9);
    const top = stages(pen, rows, x, width, height - LINE);
    curve(pen, rows, x, top, height - LINE - top - 2, width);
    const [first, last] = [rows[0], rows.at(-1)];
    pen.font = '10px system-ui, sans-serif';
    pen.fillStyle = color('soft');
    pen.fillText(seconds(first.seconds), LEFT, height - 2);
    pen.textAlign = 'right';
    pen.fillText(seconds(last.seconds), width - 1, height - 2);
    pen.textAlign = 'left';
    canvas.setAttribute('aria-label', `Convergence in ${rows.length} records: δ from ${brief(deltaOf(first))} to ${brief(deltaOf(last))}`);
    return `δ: how much the distances between neighbours vary; 0 is perfectly even.${rise(rows, isMesh)}`;
}
