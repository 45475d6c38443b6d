/* The clouds on the screen: which are there, how they are looked at, and the controls for it. */
import { dropCloud, measures } from './cloud.js';
import { $, brief, count, show } from './dom.js';
import { deltaOf, drawHistogram, rangeOf } from './histogram.js';
import { color } from './theme.js';
import { makeView } from './view.js';

const clouds = { input: null, result: null, reference: null };
let view = null, drawing = 0, told = [], chosenBy = {}; /* told: what the histogram shows; chosenBy: the user, which of mode and style */

const layout = (which) => /** @type {HTMLInputElement} */ (document.querySelector(`input[name="layout"]${which}`));
const chosen = () => layout(':checked').value;

function describe() {
    const words = Object.entries(clouds).filter(([, cloud]) => cloud).map(([name, cloud]) => `${name} with ${count(cloud.n)} points`);
    $('canvas').setAttribute('aria-label', words.length ? `Point clouds: ${words.join(', ')}` : 'No cloud yet');
    show($('captions'), view && words.length);
    show($('canvas-empty'), view && !words.length);
    for (const [name, cloud] of Object.entries(clouds)) $(`caption-${name}`).textContent = cloud ? captionOf(name, cloud) : '';
}

/* How many points and, once it is measured, how even: the page's own figure, for the input as for the result. */
function captionOf(name, cloud) {
    const delta = cloud.spacing ? deltaOf(cloud.spacing.values, cloud.spacing.mean) : NaN;
    return `${name}: ${count(cloud.n)} points${Number.isFinite(delta) ? `, δ\u00a0${brief(delta)}` : ''}`;
}

/* The captions name what is on which side. */
function caption(layout) {
    const both = layout === 'both' || layout === 'swipe';
    show($('caption-input'), both || layout === 'input');
    show($('caption-result'), both || layout === 'result');
    show($('split-label'), layout === 'swipe');
    show($('divider'), view && both);
    $('divider').classList.toggle('handle', layout === 'swipe');
    $('divider').style.left = `${layout === 'swipe' ? 100 * Number($('split').value) : 50}%`;
}

/* The divider goes where it is dragged to, as by its slider. */
function wireDivider() {
    const draw = () => {
        view.set({ split: Number($('split').value) });
        caption(chosen());
    };
    $('split').addEventListener('input', draw);
    $('divider').addEventListener('pointerdown', (event) => {
        event.preventDefault();
        $('divider').setPointerCapture(event.pointerId);
    });
    $('divider').addEventListener('pointermove', (event) => {
        if (!$('divider').hasPointerCapture(event.pointerId)) return;
        const box = $('canvas').getBoundingClientRect();
        $('split').value = String((event.clientX - box.left) / box.width);
        draw();
    });
}

/* Colours a cloud. Resolves to the figures of its histogram: distances where these are its colours, else spacings. */
async function colour(name, mode) {
    const cloud = clouds[name], slot = view.slot(name), isDistance = mode === 'distance' && name === 'result' && clouds.input;
    if (mode !== 'spacing' && !isDistance) slot.setMode(mode === 'original' && !cloud.colors || mode === 'distance' ? 'plain' : mode, 0, 1);
    const { values, mean } = isDistance ? await measures.distance(cloud, clouds.input) : await measures.spacing(cloud);
    if (clouds[name] !== cloud) return null;
    const figures = isDistance ? 'distance' : 'spacing', range = rangeOf(figures, values, mean);
    if (mode === figures) {
        slot.setValues(values);
        slot.setMode(mode, range.low, range.high);
    }
    return { figures, values, whose: name, isShown: mode === figures, delta: deltaOf(values, mean), ...range };
}

/* Side by side each cloud has a histogram below it, else the one that is seen best has it, and the other is a line. */
function panelsOf({ input, result }, mode) {
    if (mode === 'distance' && result) return [{ one: result }];
    if (chosen() === 'both' && input && result) return [{ one: input }, { one: result }];
    const first = chosen() === 'input' ? input || result : result || input, other = first === input ? result : input;
    return first ? [{ one: first, other }] : [];
}

function drawTold() {
    $('histogram').classList.toggle('unseen-yet', !told.length);
    if (told.length && $('histogram-canvas').clientWidth) drawHistogram($('histogram-canvas'), $('histogram-caption'), told);
}

/* Colours what is shown; figures that take long are waited for, and given up when something else was asked meanwhile. */
async function recolour() {
    const mode = $('mode').value, turn = ++drawing, found = { input: undefined, result: undefined };
    view.set({ mode, style: $('style').value });
    for (const name of ['input', 'result']) {
        if (!clouds[name]) continue;
        found[name] = await colour(name, mode).catch(() => null);
        if (turn !== drawing) return;
    }
    told = panelsOf(found, mode);
    describe();
    drawTold();
    view.set({});
}

async function learn(name, cloud) {
    const spacing = await measures.spacing(cloud);
    if (clouds[name] === cloud) view.setSpacing(name, spacing.mean);
    describe();
    const surface = await measures.surface(cloud);
    if (clouds[name] !== cloud) return;
    view.slot(name).setSurface(surface);
    view.set({});
}

/* A view begins with what says most: dots coloured by spacing; triangles, which show their own sizes, in one colour; an input that has
 * colours, as long as there is no result, as a picture of discs in them. A choice of the user's stays as long as the input does. */
function preset(cloud, isResult) {
    const isPicture = cloud.colors && !isResult;
    if (!chosenBy.mode) $('mode').value = clouds.reference ? 'plain' : isPicture ? 'original' : cloud.faces ? 'plain' : 'spacing';
    if (!chosenBy.style) $('style').value = cloud.faces ? 'triangles' : isPicture ? 'discs' : 'dots';
}

function offer() {
    const { input, result } = clouds, option = (name, value) => $(name).querySelector(`[value="${value}"]`);
    $('looks').classList.toggle('unseen-yet', !(view && (input || result)));
    $('layouts').disabled = !(input && result);
    option('mode', 'original').disabled = !(input?.colors || result?.colors);
    option('mode', 'distance').disabled = !(input && result);
    for (const value of ['triangles', 'surface']) option('style', value).disabled = !(input?.faces || result?.faces);
    for (const name of ['mode', 'style']) if ($(name).selectedOptions[0]?.disabled) $(name).value = name === 'mode' ? 'spacing' : 'dots';
}

/** Puts a cloud into a pane, or takes it out (null). A new input is fitted into the view, with the reference where there is one, which
 *  is drawn in both panes. */
export function setCloud(name, cloud) {
    const isNew = name !== 'result' || !clouds[name] || Boolean(clouds[name].faces) !== Boolean(cloud?.faces); /* to points on the move triangles come */
    if (clouds[name] !== cloud) dropCloud(clouds[name]);
    clouds[name] = cloud;
    if (name === 'input') chosenBy = {};
    if (!clouds.input && !clouds.result) told = [];
    describe();
    if (!view) return;
    view.setCloud(name, cloud, name !== 'result' || !clouds.input);
    if (cloud && isNew) preset(cloud, name === 'result');
    offer();
    drawTold();
    if (!cloud) return;
    recolour();
    learn(name, cloud).catch(() => {});
}

export const getCloud = (name) => clouds[name];

/** Whether clouds are drawn at all. */
export const canDraw = () => Boolean(view);

/** Shows input, result, both or swipe. */
export function setLayout(name) {
    layout(`[value="${name}"]`).checked = true;
    caption(name);
    if (view) {
        view.set({ layout: name });
        recolour();
    }
}

export const blink = () => clouds.input && clouds.result && setLayout(chosen() === 'input' ? 'result' : 'input');

/* What the space bar does something to by itself: not sliders, nor the layout that is chosen already. */
const takesSpace = (one) => /^(input|select|button|textarea|summary|a)$/i.test(one.tagName) && one.type !== 'range'
    && !(one.name === 'layout' && one.checked);

function dressed() {
    if (view) view.set({ background: color('canvas'), plain: color('point'), other: color('sigma') });
    drawTold();
}

/** Wires the controls. Returns what to call when the colours of the page have changed. */
export function wireStage(save) {
    view = makeView($('canvas'));
    show($('no-webgl'), !view);
    show($('canvas'), Boolean(view));
    describe();
    if (!view) return () => {};
    $('layouts').addEventListener('change', () => setLayout(chosen()));
    for (const name of ['mode', 'style']) {
        $(name).addEventListener('change', () => {
            chosenBy[name] = true;
            recolour();
        });
    }
    $('size').addEventListener('input', () => view.set({ size: Number($('size').value) }));
    wireDivider();
    new ResizeObserver(drawTold).observe($('histogram-canvas'));
    $('shaded').addEventListener('change', () => view.set({ shaded: $('shaded').checked }));
    $('up').addEventListener('click', () => view.fit(view.up() === 'z' ? 'y' : 'z'));
    $('fit').addEventListener('click', () => view.fit(view.up()));
    $('png').addEventListener('click', async () => save(await view.toBlob(), 'png'));
    document.addEventListener('keydown', (event) => {
        if (event.key !== ' ' || takesSpace(event.target) || !clouds.input || !clouds.result) return;
        event.preventDefault();
        blink();
    });
    view.set({ size: Number($('size').value) });
    return dressed;
}
