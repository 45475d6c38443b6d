/* A cloud as three.js draws it: dots that show how evenly it is spread, discs that touch and so show a surface, or the triangles of a mesh.
 * Behind dots lies a cover that is not seen itself and hides the dots of the far side: the triangles of a mesh, else discs. */
import { BufferAttribute, BufferGeometry, Color, DoubleSide, Group, Mesh, MeshBasicMaterial, Points, ShaderMaterial, Sphere, Vector3 }
    from 'three';
import { MOVING_MAX, MOVING_MIN } from './pace.js';
import { MODES, stops } from './palette.js';

/* The wires of a mesh: how dark they are, and pixels of an edge below which they are paler, so that they never hide the surface. */
const [WIRE, WIRE_PIXELS] = [0.45, 12];
const WIDER_MAX = 3; /* times that points grow at most where fewer are drawn */
/* Diameters, of a dot over the mean spacing and of a disc over its width: neighbouring dots never touch, neighbouring discs always do. */
const [DOT, DISC] = [0.55, 1.4];
/* Widths that the cover lies behind the points, and of its discs: on a slope it would hide the next row of them otherwise, of a noisy scan the
 * deeper points; and discs of 1.16 widths just leave no gap among points that are even. */
const [BACK, COVER] = [2, 1.2];

/* What both kinds of shaders begin with: the colour of a point in each mode, and the light, which comes from beside the eye. */
const COLORS = `
attribute vec3 tint;
attribute float value;
uniform float low, high;
uniform int mode;
uniform vec3 plain;
uniform vec3 stop[5];
varying vec3 shown;
vec3 ramp(float t) {
    float at = clamp(t, 0.0, 1.0) * 4.0;
    vec3 color = stop[0];
    for (int k = 0; k < 4; k++) color = mix(color, stop[k + 1], clamp(at - float(k), 0.0, 1.0));
    return color;
}
vec3 colour() {
    if (mode == 1) return tint;
    if (mode == 2 || mode == 3) return ramp((value - low) / max(high - low, 1e-30));
    return plain;
}`;
const LIGHT = `
float light(vec3 facing, float dark) {
    return dark + (1.05 - dark) * clamp(dot(facing, normalize(vec3(0.25, 0.35, 1.0))), 0.0, 1.0);
}
vec4 behind(vec4 seen, float far) {
    return vec4(seen.xyz * (1.0 + far / max(length(seen.xyz), 1e-30)), 1.0);
}`;
const VERTEX = `
attribute float width;
uniform float size, spacing, scale, wider, back;
uniform bool shaded, disc;
varying vec3 tilt;${COLORS}${LIGHT}
void main() {
    vec4 seen = modelViewMatrix * vec4(position, 1.0);
    vec3 facing = normalMatrix * normal;
    facing = dot(facing, seen.xyz) > 0.0 ? -facing : facing;
    tilt = facing;
    shown = mode == 4 ? 0.5 + 0.5 * facing : colour();
    if (shaded) shown *= light(normalize(facing), disc ? 0.4 : 0.7);
    float own = width > 0.0 ? width : spacing, diameter = disc ? DISC * own : DOT * spacing;
    gl_Position = projectionMatrix * behind(seen, back * own);
    if (back > 0.0) diameter = COVER * own;
    gl_PointSize = clamp((back > 0.0 ? 1.0 : size) * wider * diameter * scale / max(gl_Position.w, 1e-30), disc ? 1.5 : 2.2, 64.0);
}`.replace('DISC', DISC.toFixed(2)).replace('DOT', DOT.toFixed(2)).replace('COVER', COVER.toFixed(2));
/* A disc lies in its surface, so that seen from the side it is narrow; at most so much that it stays to be seen. */
const FRAGMENT = `
uniform bool disc;
varying vec3 shown, tilt;
void main() {
    vec2 off = gl_PointCoord - 0.5;
    float deep = !disc ? 0.0 : dot(vec2(off.x, -off.y), tilt.xy) / max(tilt.z, 0.4);
    if (dot(off, off) + deep * deep > 0.25) discard;
    gl_FragColor = vec4(shown, 1.0);
}`;
const FACE_VERTEX = `${COLORS}${LIGHT}
uniform float spacing, faceBack;
varying vec3 seen;
void main() {
    vec4 at = modelViewMatrix * vec4(position, 1.0);
    seen = at.xyz;
    shown = colour();
    gl_Position = projectionMatrix * behind(at, faceBack * spacing);
}`;
const FACE_FRAGMENT = `
uniform int mode;
uniform bool lit;
varying vec3 seen, shown;${LIGHT}
void main() {
    vec3 facing = normalize(cross(dFdx(seen), dFdy(seen)));
    facing = facing.z < 0.0 ? -facing : facing;
    gl_FragColor = vec4(mode == 4 ? 0.5 + 0.5 * facing : shown * (lit ? light(facing, 0.4) : 1.0), 1.0);
}`;

function material() {
    const vectors = Array.from({ length: 5 }, () => new Vector3());
    return new ShaderMaterial({ vertexShader: VERTEX, fragmentShader: FRAGMENT, uniforms: {
        size: { value: 1 }, spacing: { value: 1 }, scale: { value: 1 }, wider: { value: 1 }, low: { value: 0 }, high: { value: 1 }, mode: { value: 0 },
        disc: { value: false }, back: { value: 0 }, faceBack: { value: 0 },
        shaded: { value: false }, lit: { value: false }, plain: { value: new Color(0x888888) }, stop: { value: vectors } } });
}

/* What hides the dots behind it: only its depth is drawn. */
function coverOf(geometry, { uniforms }) {
    const look = new ShaderMaterial({ vertexShader: VERTEX, fragmentShader: FRAGMENT, colorWrite: false,
        uniforms: { ...uniforms, disc: { value: true }, back: { value: BACK } } });
    const cover = new Points(geometry, look);
    cover.renderOrder = -1;
    return cover;
}

/* One point of each run of as many, taken by a fixed generator: rows of a scanner would else show as stripes. Shuffled, so that the
 * first ones, however many, are of the whole. */
function sample(n) {
    const count = Math.min(n, MOVING_MAX), out = new Uint32Array(count), stride = n / count;
    let state = 1;
    const draw = () => (state = (Math.imul(state, 1664525) + 1013904223) >>> 0) / 4294967296;
    for (let i = 0; i < count; i++) {
        const other = Math.floor(draw() * (i + 1));
        out[i] = out[other];
        out[other] = Math.min(n - 1, Math.floor((i + draw()) * stride));
    }
    return new BufferAttribute(out, 1);
}

function sphereOf({ low, high }) {
    const [from, to] = [new Vector3(...low), new Vector3(...high)];
    return new Sphere(from.clone().add(to).multiplyScalar(0.5), Math.max(from.distanceTo(to) / 2, 1e-30));
}

/* The faces share what their corners have with the points. */
function meshOf(faces, points, { uniforms }) {
    const geometry = new BufferGeometry(), group = new Group();
    geometry.setIndex(new BufferAttribute(faces, 1));
    geometry.boundingSphere = points.boundingSphere;
    const skin = new ShaderMaterial({ vertexShader: FACE_VERTEX, fragmentShader: FACE_FRAGMENT, uniforms, side: DoubleSide, polygonOffset: true,
        polygonOffsetFactor: 1, polygonOffsetUnits: 1 });
    const wire = new MeshBasicMaterial({ color: 0x10141a, wireframe: true, transparent: true });
    group.add(new Mesh(geometry, skin), new Mesh(geometry, wire));
    group.children[0].renderOrder = -1;
    return { group, skin, wire, wires: group.children[1],
        share() {
            for (const name of ['position', 'tint', 'value'])
                if (points.attributes[name]) geometry.setAttribute(name, points.attributes[name]);
        },
        free: () => [geometry, skin, wire].forEach((one) => one.dispose()) };
}

/** Makes what is drawn of a cloud (as cloud.js reads it). set*() change how; free() gives the card's memory back. */
export function makePoints(cloud) {
    const geometry = new BufferGeometry(), look = material(), sphere = sphereOf(cloud);
    const few = cloud.n > MOVING_MIN && !cloud.faces ? sample(cloud.n) : null, root = new Group();
    geometry.setAttribute('position', new BufferAttribute(cloud.positions, 3));
    if (cloud.colors) geometry.setAttribute('tint', new BufferAttribute(cloud.colors, 3, true));
    if (cloud.normals) geometry.setAttribute('normal', new BufferAttribute(cloud.normals, 3));
    geometry.boundingSphere = sphere;
    const mesh = cloud.faces ? meshOf(cloud.faces, geometry, look) : null, cover = mesh ? mesh.group : coverOf(geometry, look);
    const points = new Points(geometry, look), { uniforms } = look;
    root.add(points, cover);
    mesh?.share();
    return {
        root, sphere, positions: cloud.positions,
        /* How many points or triangles are drawn. */
        drawn: () => (points.visible ? Math.min(cloud.n, geometry.drawRange.count) : cloud.faces.length / 3),
        /* dots, discs, triangles with their edges (wires), or the surface of them; a cloud without triangles has dots for these. */
        setStyle(style) {
            const isFaces = Boolean(mesh) && /triangles|surface/.test(style), isDiscs = style === 'discs';
            points.visible = !isFaces;
            cover.visible = !isDiscs;
            uniforms.disc.value = isDiscs;
            if (!mesh) return;
            mesh.skin.colorWrite = isFaces;
            uniforms.faceBack.value = isFaces ? 0 : 0.5;
            mesh.wires.visible = style === 'triangles';
        },
        /* While the view moves at most `budget` points are drawn, wider ones where that are not all. */
        setMoving(moving, budget) {
            if (!few) return;
            const shown = moving ? Math.min(few.count, budget) : cloud.n;
            geometry.setIndex(moving ? few : null);
            geometry.setDrawRange(0, shown);
            uniforms.wider.value = Math.min(WIDER_MAX, Math.sqrt(cloud.n / shown));
        },
        setMode(mode, low, high) {
            uniforms.mode.value = MODES[mode];
            [uniforms.low.value, uniforms.high.value] = [low, high];
            stops(mode).forEach((color, k) => uniforms.stop.value[k].fromArray(color));
        },
        setSurface({ normals, widths }) {
            if (!geometry.attributes.normal) geometry.setAttribute('normal', new BufferAttribute(normals, 3));
            geometry.setAttribute('width', new BufferAttribute(widths, 1));
        },
        setValues(values) {
            geometry.setAttribute('value', new BufferAttribute(values, 1));
            mesh?.share();
        },
        setShaded(shaded) {
            uniforms.shaded.value = shaded && Boolean(geometry.attributes.normal);
            uniforms.lit.value = shaded;
        },
        setPlain: (color) => uniforms.plain.value.set(color),
        /* How wide points are: size times the spacing for dots, the width of each for discs (the spacing until widths are there). */
        setSize(size, spacing) {
            [uniforms.size.value, uniforms.spacing.value] = [size, spacing];
        },
        /* Pixels of a unit at distance 1; distance: of the eye from what it looks at. */
        setScale(scale, distance) {
            uniforms.scale.value = scale;
            if (mesh) mesh.wire.opacity = WIRE * Math.min(1, uniforms.spacing.value * scale / distance / WIRE_PIXELS);
        },
        free() {
            geometry.dispose();
            look.dispose();
            if (mesh) mesh.free();
            else cover.material.dispose();
        },
    };
}
