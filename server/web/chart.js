/* How even the points are, record by record: delta, sigma and epsilon in a strip each, over the time of the run. */
import { figure, seconds } from './dom.js';
import { color } from './theme.js';

const STRIPS = [
    { name: 'delta', words: 'δ', log: true },
    { name: 'sigma', words: 'σ', log: true },
    { name: 'epsilon', words: 'ε', log: false },
];
const LEFT = 72, LINE = 12, GAP = 10; /* pixels: room for figures, for a line of names of stages or of times, between strips */
const STAGES = { iterate: 'iterations', project: 'projection', insert: 'insertion' }; /* others by their own names */

const least = (values) => values.reduce((a, b) => Math.min(a, b), Infinity);
const greatest = (values) => values.reduce((a, b) => Math.max(a, b), -Infinity);
const wordsOf = (name, value) => (name === 'epsilon' ? value.toFixed(5) : figure(value));

function scaleOf(values, log, top, height) {
    const shown = log ? values.filter((value) => value > 0).map(Math.log) : values;
    const low = least(shown), span = greatest(shown) - low || 1;
    return (value) => top + height - ((log ? Math.log(Math.max(value, 1e-300)) : value) - low) / span * height;
}

/* What the top and the bottom of a strip stand for. */
function bounds(pen, values, name, top, height) {
    const [low, high] = [least(values), greatest(values)];
    pen.font = '10px system-ui, sans-serif';
    pen.fillStyle = color('soft');
    pen.textAlign = 'right';
    pen.fillText(wordsOf(name, high), LEFT - 4, top + 9);
    if (low < high) pen.fillText(wordsOf(name, low), LEFT - 4, top + height - 1);
    pen.textAlign = 'left';
}

function strip(pen, rows, x, { name, words, log }, top, height, width) {
    const values = rows.map((row) => row[name]), y = scaleOf(values, log, top + 4, height - 8);
    pen.strokeStyle = color('line');
    pen.strokeRect(LEFT, top, width - LEFT - 1, height);
    pen.strokeStyle = pen.fillStyle = color(name);
    pen.lineWidth = 1.5;
    pen.beginPath();
    rows.forEach((row, k) => (k ? pen.lineTo(x(row), y(row[name])) : pen.moveTo(x(row), y(row[name]))));
    pen.stroke();
    const last = rows.at(-1);
    pen.beginPath();
    pen.arc(x(last), y(last[name]), 3, 0, 2 * Math.PI);
    pen.fill();
    pen.font = '600 13px system-ui, sans-serif';
    pen.fillText(words, 2, top + height / 2 - 3);
    pen.font = '11px system-ui, sans-serif';
    pen.fillText(wordsOf(name, last[name]), 2, top + height / 2 + 11);
    pen.lineWidth = 1;
    bounds(pen, values, name, top, height);
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

/** Draws records into a canvas and says in its label what is to be seen. */
export function drawChart(canvas, records) {
    const rows = records.filter((row) => STRIPS.every(({ name }) => typeof row[name] === 'number'));
    const ratio = window.devicePixelRatio || 1, [width, height] = [canvas.clientWidth, canvas.clientHeight], pen = canvas.getContext('2d');
    canvas.dataset.points = String(rows.length);
    if (!rows.length || !width) return;
    [canvas.width, canvas.height] = [Math.round(width * ratio), Math.round(height * ratio)];
    pen.scale(ratio, ratio);
    const from = rows[0].seconds, span = rows.at(-1).seconds - from || 1, x = (row) => LEFT + 4 + (row.seconds - from) / span * (width - LEFT - 9);
    const top = stages(pen, rows, x, width, height - LINE), each = (height - LINE - top - 2 * GAP - 2) / 3;
    STRIPS.forEach((one, k) => strip(pen, rows, x, one, top + k * (each + GAP), each, width));
    const [first, last] = [rows[0], rows.at(-1)];
    pen.font = '10px system-ui, sans-serif';
    pen.fillStyle = color('soft');
    pen.fillText(seconds(first.seconds), LEFT, height - 2);
    pen.textAlign = 'right';
    pen.fillText(seconds(last.seconds), width - 1, height - 2);
    pen.textAlign = 'left';
    canvas.setAttribute('aria-label', `Convergence in ${rows.length} records: delta from ${figure(first.delta)} to ${figure(last.delta)}, `
        + `sigma from ${figure(first.sigma)} to ${figure(last.sigma)}, epsilon from ${first.epsilon.toFixed(5)} to ${last.epsilon.toFixed(5)}`);
}
