/* The clouds on the screen: which are there, how they are looked at, and the controls for it. */
import { dropCloud, measures } from './cloud.js';
import { $, count, show } from './dom.js';
import { drawHistogram, rangeOf } from './histogram.js';
import { color } from './theme.js';
import { makeView } from './view.js';

const clouds = { input: null, result: null };
let view = null, drawing = 0, told = null; /* told: what the histogram shows */

const layout = (which) => /** @type {HTMLInputElement} */ (document.querySelector(`input[name="layout"]${which}`));
const chosen = () => layout(':checked').value;
const whichHas = (name) => Boolean(clouds[name]);

function describe() {
    const words = Object.entries(clouds).filter(([, cloud]) => cloud).map(([name, cloud]) => `${name} with ${count(cloud.n)} points`);
    $('canvas').setAttribute('aria-label', words.length ? `Point clouds: ${words.join(', ')}` : 'No cloud yet');
    show($('captions'), view && whichHas('result'));
    show($('canvas-empty'), view && !words.length);
    $('stage').classList.toggle('empty', Boolean(view) && !words.length);
    for (const [name, cloud] of Object.entries(clouds)) $(`caption-${name}`).textContent = cloud ? `${name}: ${count(cloud.n)} points` : '';
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

/* The curtain goes where it is dragged to, as by its slider. */
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

async function colour(name, mode) {
    const cloud = clouds[name], slot = view.slot(name);
    if (mode === 'spacing' || (mode === 'distance' && name === 'result' && clouds.input)) {
        const { values, mean } = mode === 'spacing' ? await measures.spacing(cloud) : await measures.distance(cloud, clouds.input);
        if (clouds[name] !== cloud) return null;
        const range = rangeOf(mode, values, mean);
        slot.setValues(values);
        slot.setMode(mode, range.low, range.high);
        return { mode, values, whose: name, ...range };
    }
    slot.setMode(mode === 'original' && !cloud.colors || mode === 'distance' ? 'plain' : mode, 0, 1);
    return null;
}

function drawTold() {
    if (told?.[0] && $('histogram-canvas').clientWidth) drawHistogram($('histogram-canvas'), $('histogram-caption'), ...told);
}

/* Colours what is shown; figures that take long are waited for, and given up when something else was asked meanwhile. */
async function recolour() {
    const mode = $('mode').value, turn = ++drawing;
    const found = {};
    for (const name of ['input', 'result']) {
        if (!clouds[name]) continue;
        found[name] = await colour(name, mode);
        if (turn !== drawing) return;
    }
    const { input, result } = found;
    told = chosen() === 'input' && input ? [input, result] : [result || input, result && input];
    show($('histogram'), Boolean(told[0]));
    drawTold();
    view.set({ mode });
}

async function learn(name, cloud) {
    const spacing = await measures.spacing(cloud);
    if (clouds[name] === cloud) view.setSpacing(name, spacing.mean);
    const surface = await measures.surface(cloud);
    if (clouds[name] !== cloud) return;
    view.slot(name).setSurface(surface);
    view.set({});
}

/** Puts a cloud into a pane, or takes it out (null). A new input is fitted into the view. */
export function setCloud(name, cloud) {
    if (clouds[name] !== cloud) dropCloud(clouds[name]);
    clouds[name] = cloud;
    show($('looks'), view && (clouds.input || clouds.result));
    show($('layouts'), Boolean(clouds.input && clouds.result));
    show($('mesh-look'), Boolean(clouds.input?.faces || clouds.result?.faces));
    describe();
    if (!view) return;
    view.setCloud(name, cloud, name === 'input' || !clouds.input);
    if (!cloud) return;
    if (name === 'input') $('mode').value = cloud.colors ? 'original' : 'plain';
    $('mode').querySelector('[value="original"]').disabled = !(clouds.input?.colors || clouds.result?.colors);
    $('mode').querySelector('[value="distance"]').disabled = !(clouds.input && clouds.result);
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
    if (view) view.set({ background: color('canvas'), plain: color('point') });
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
    $('mode').addEventListener('change', recolour);
    $('size').addEventListener('input', () => view.set({ size: Number($('size').value) }));
    wireDivider();
    new ResizeObserver(drawTold).observe($('histogram-canvas'));
    $('shaded').addEventListener('change', () => view.set({ shaded: $('shaded').checked }));
    $('wires').addEventListener('change', () => view.set({ wires: $('wires').checked }));
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
