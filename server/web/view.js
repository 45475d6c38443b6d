/*! three.js r111 (https://threejs.org), part of this file, is under the MIT License:
Copyright (c) 2010-2019 three.js authors
Permission is hereby granted, free of charge, to any person obtaining a copy of this software and associated documentation files (the
"Software"), to deal in the Software without restriction, including without limitation the rights to use, copy, modify, merge, publish,
distribute, sublicense, and/or sell copies of the Software, and to permit persons to whom the Software is furnished to do so, subject to
the following conditions: The above copyright notice and this permission notice shall be included in all copies or substantial portions
of the Software. THE SOFTWARE IS PROVIDED "AS IS", WITHOUT WARRANTY OF ANY KIND, EXPRESS OR IMPLIED, INCLUDING BUT NOT LIMITED TO THE
WARRANTIES OF MERCHANTABILITY, FITNESS FOR A PARTICULAR PURPOSE AND NONINFRINGEMENT. IN NO EVENT SHALL THE AUTHORS OR COPYRIGHT HOLDERS
BE LIABLE FOR ANY CLAIM, DAMAGES OR OTHER LIABILITY, WHETHER IN AN ACTION OF CONTRACT, TORT OR OTHERWISE, ARISING FROM, OUT OF OR IN
CONNECTION WITH THE SOFTWARE OR THE USE OR OTHER DEALINGS IN THE SOFTWARE. */
/* The canvas: two clouds under one camera, side by side, behind a curtain, or one at a time, each with the reference that a cloud is to be
 * laid on. It draws when something changed. */
import { Box3, Color, PerspectiveCamera, Scene, Sphere, Vector3, WebGLRenderer } from 'three';
import { OrbitControls } from 'orbit-controls';
import { MOVING_MAX, nextBudget } from './pace.js';
import { makePoints } from './points.js';

const FIELD_OF_VIEW = 40; /* degrees, of the height or, where that is less, the width of a pane */
const REST_MS = 200;      /* without a movement, after which every point is drawn */
const TURN = 0.12;        /* radians a stroke of an arrow key */
const MARGIN = 1.06;      /* around a cloud that is fitted into the view */
const FINE = 2;           /* pixels drawn for one of a coarse screen at rest */
const FIT_POINTS = 20000; /* of the cloud that are looked at for it */

/* Clouds whose third axis is by far the shortest are land or floors: that axis is up. Others stand on the second. */
function upOf({ low, high }) {
    const [x, y, z] = high.map((value, k) => value - low[k]);
    return z < 0.6 * Math.max(x, y) && z <= y ? 'z' : 'y';
}

/* How far from its centre a cloud is seen whole by an eye that looks along -toward; aspect: of the pane. */
function distanceOf({ positions, sphere: { center } }, up, toward, aspect) {
    const tangent = Math.tan(FIELD_OF_VIEW * Math.PI / 360), side = new Vector3().crossVectors(up, toward).normalize();
    const over = new Vector3().crossVectors(toward, side), at = new Vector3(), step = 3 * Math.ceil(positions.length / 3 / FIT_POINTS);
    const [wide, high] = [tangent * Math.max(aspect, 1), tangent / Math.min(aspect, 1)];
    let most = 0;
    for (let i = 0; i < positions.length; i += step) {
        at.fromArray(positions, i).sub(center);
        most = Math.max(most, at.dot(toward) + Math.max(Math.abs(at.dot(side)) / wide, Math.abs(at.dot(over)) / high));
    }
    return most;
}

/* What is fitted into the view: one cloud, or two together. */
function together(one, other) {
    if (!other) return one;
    const positions = new Float32Array(one.positions.length + other.positions.length);
    positions.set(one.positions);
    positions.set(other.positions, one.positions.length);
    return { positions, sphere: new Box3().setFromArray(positions).getBoundingSphere(new Sphere()) };
}

/** Makes the view in a canvas. Returns null where the browser has no WebGL2. */
export function makeView(canvas) {
    /* A disc of many pixels has no edge that multisampling would smooth, and a browser that draws by software takes twice as long for it. */
    const context = canvas.getContext('webgl2', { antialias: false, alpha: false });
    if (!context) return null;
    const renderer = new WebGLRenderer({ canvas, context });
    const camera = new PerspectiveCamera(FIELD_OF_VIEW, 1, 0.01, 100);
    const [input, result, reference] = [1, 2, 3].map(() => ({ scene: new Scene(), slot: null })), panes = { input, result, reference };
    const look = { layout: 'input', split: 0.5, size: 1, mode: 'plain', shaded: true, style: 'dots' };
    let controls = new OrbitControls(camera, canvas), moving = 0, held = false, frame = 0, framed = null, touched = false;
    let isMoving = false, budget = MOVING_MAX, drawn = 0;
    renderer.autoClear = false;

    const slots = () => Object.values(panes).map((pane) => pane.slot).filter(Boolean);
    const draw = () => { frame = frame || requestAnimationFrame(render); };
    const rest = () => {
        if (held) return;
        isMoving = false;
        slots().forEach((slot) => slot.setMoving(false));
        draw();
    };
    const move = () => {
        clearTimeout(moving);
        moving = setTimeout(rest, REST_MS);
        isMoving = true;
        const seen = /both|swipe/.test(look.layout) ? 2 : 1;
        slots().forEach((slot) => slot.setMoving(true, Math.floor(budget / seen)));
        draw();
    };
    const hold = (isHeld) => {
        held = isHeld;
        touched = true;
        move();
    };

    function show(pane, x, width, viewX, viewWidth) {
        const height = canvas.clientHeight;
        camera.aspect = viewWidth / height;
        camera.fov = camera.aspect < 1 ? 2 * Math.atan(Math.tan(FIELD_OF_VIEW * Math.PI / 360) / camera.aspect) * 180 / Math.PI : FIELD_OF_VIEW;
        camera.updateProjectionMatrix();
        renderer.setViewport(viewX, 0, viewWidth, height);
        renderer.setScissor(x, 0, width, height);
        renderer.setScissorTest(true);
        for (const { scene, slot } of [panes.reference, pane]) {
            if (slot) {
                const scale = camera.projectionMatrix.elements[5] * renderer.getPixelRatio() * height / 2;
                slot.setScale(scale, camera.position.distanceTo(controls.target));
                drawn += slot.drawn();
            }
            renderer.render(scene, camera);
        }
    }

    /* At rest edges and wires are smoothed by drawing twice as fine, where screens are coarse and the points not too many. */
    function sharpen() {
        const most = Math.max(0, ...slots().map((slot) => slot.positions.length / 3)), own = window.devicePixelRatio || 1;
        const ratio = own < FINE && !isMoving && most <= MOVING_MAX ? FINE * own : own;
        if (renderer.getPixelRatio() !== ratio) renderer.setPixelRatio(ratio);
    }

    function render() {
        const [width, height] = [canvas.clientWidth, canvas.clientHeight];
        frame = drawn = 0;
        if (!width || !height) return;
        sharpen();
        if (isMoving) {
            const began = performance.now();
            requestAnimationFrame(() => { budget = nextBudget(budget, performance.now() - began); });
        }
        renderer.setScissorTest(false);
        renderer.clear();
        if (framed) {
            const { sphere } = framed, far = camera.position.distanceTo(sphere.center) + 2 * sphere.radius;
            camera.near = Math.max(far - 4 * sphere.radius, far / 1000);
            camera.far = far;
        }
        if (look.layout === 'both') {
            show(panes.input, 0, width / 2, 0, width / 2);
            show(panes.result, width / 2, width / 2, width / 2, width / 2);
        } else if (look.layout === 'swipe') {
            show(panes.input, 0, width * look.split, 0, width);
            show(panes.result, width * look.split, width * (1 - look.split), 0, width);
        } else show(panes[look.layout], 0, width, 0, width);
        canvas.dataset.frames = String(1 + Number(canvas.dataset.frames || 0));
        canvas.dataset.drawn = String(drawn);
    }

    /* The whole cloud, from where it is looked at first. */
    function place() {
        const up = camera.up, toward = (up.z > 0.5 ? new Vector3(0.55, -1, 0.75) : new Vector3(0.35, 0.35, 1)).normalize();
        const width = look.layout === 'both' ? canvas.clientWidth / 2 : canvas.clientWidth, { center, radius } = framed.sphere;
        const distance = distanceOf(framed, up, toward, width / canvas.clientHeight || 1) || radius;
        camera.position.copy(center).addScaledVector(toward, MARGIN * distance);
        controls.target.copy(center);
        controls.update();
        touched = false;
        draw();
    }

    function fit(up) {
        if (!framed) return;
        camera.up.set(0, up === 'z' ? 0 : 1, up === 'z' ? 1 : 0);
        controls.dispose(); /* it keeps the axis that was up when it was made */
        controls = new OrbitControls(camera, canvas);
        controls.enableKeys = false;
        controls.addEventListener('change', move);
        controls.addEventListener('start', () => hold(true));
        controls.addEventListener('end', () => hold(false));
        place();
    }

    function dress(slot) {
        slot.setSize(look.size, slot.spacing);
        slot.setPlain((slot === panes.reference.slot ? look.other : look.plain) || 0x888888);
        slot.setShaded(look.shaded && look.mode !== 'normals');
        slot.setStyle(look.style);
    }

    function resize() {
        renderer.setSize(canvas.clientWidth, canvas.clientHeight, false);
        if (framed && !touched && canvas.clientWidth) place();
        draw();
    }

    /* The keys of a canvas that has the focus: arrows turn, plus and minus come nearer and go away. */
    canvas.addEventListener('keydown', (event) => {
        const turn = { ArrowLeft: [-TURN, 0], ArrowRight: [TURN, 0], ArrowUp: [0, -TURN], ArrowDown: [0, TURN] }[event.key];
        const nearer = { '+': 0.9, '-': 1 / 0.9 }[event.key], off = camera.position.clone().sub(controls.target);
        if (!turn && !nearer) return;
        event.preventDefault();
        touched = true;
        if (turn) {
            const side = new Vector3().crossVectors(camera.up, off).normalize(), tilted = off.clone().applyAxisAngle(side, turn[1]);
            if (tilted.angleTo(camera.up) > 0.05 && tilted.angleTo(camera.up) < Math.PI - 0.05) off.copy(tilted);
            off.applyAxisAngle(camera.up, turn[0]);
        } else off.multiplyScalar(nearer);
        camera.position.copy(controls.target).add(off);
        controls.update();
    });
    new ResizeObserver(resize).observe(canvas);
    matchMedia(`(resolution: ${window.devicePixelRatio}dppx)`).addEventListener('change', resize);

    return {
        /* Puts a cloud (or null) into a pane; the camera moves only where asked. */
        setCloud(name, cloud, refit) {
            const pane = panes[name];
            if (pane.slot) {
                pane.scene.remove(pane.slot.root);
                pane.slot.free();
            }
            pane.slot = cloud ? makePoints(cloud) : null;
            if (!cloud) return draw();
            pane.slot.spacing = cloud.spacing?.mean || 1.2 * pane.slot.sphere.radius / Math.sqrt(cloud.n); /* until it is measured */
            if (cloud.surface) pane.slot.setSurface(cloud.surface);
            pane.scene.add(pane.slot.root);
            if (name === 'reference') pane.slot.setMode('plain', 0, 1);
            if (refit || !framed) {
                framed = together(pane.slot, (name === 'reference' ? panes.input : panes.reference).slot);
                fit(upOf(cloud));
            }
            dress(pane.slot);
            return cloud.n > MOVING_MAX ? move() : draw(); /* all at once would keep the first look waiting */
        },
        slot: (name) => panes[name].slot,
        /* Points are as wide as this distance, times the size that was chosen. */
        setSpacing(name, value) {
            if (value > 0) panes[name].slot.spacing = value;
            dress(panes[name].slot);
            draw();
        },
        set(changes) {
            const wasBoth = look.layout === 'both';
            Object.assign(look, changes);
            if (framed && !touched && wasBoth !== (look.layout === 'both')) place();
            if (changes.background) renderer.setClearColor(new Color(changes.background));
            slots().forEach(dress);
            draw();
        },
        look, fit, draw,
        up: () => (camera.up.z > 0.5 ? 'z' : 'y'),
        toBlob: () => new Promise((resolve) => {
            cancelAnimationFrame(frame);
            render();
            canvas.toBlob(resolve, 'image/png');
        }),
    };
}
