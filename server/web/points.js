/* A cloud as three.js draws it: discs that reach each other, shaded by normals; a mesh with its wires. */
import { BufferAttribute, BufferGeometry, Color, DoubleSide, Group, Mesh, MeshBasicMaterial, Points, ShaderMaterial, Sphere, Vector3 }
    from 'three';
import { MOVING_MAX, MOVING_MIN } from './pace.js';
import { MODES, stops } from './palette.js';

/* The wires of a mesh: how dark they are, and pixels of an edge below which they are paler, so that they never hide the surface. */
const [WIRE, WIRE_PIXELS] = [0.45, 12];
const WIDER_MAX = 3; /* times that discs grow at most where fewer are drawn */

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
float light(vec3 facing) {
    return 0.4 + 0.65 * clamp(dot(facing, normalize(vec3(0.25, 0.35, 1.0))), 0.0, 1.0);
}`;
const VERTEX = `
attribute float width;
uniform float size, spacing, scale, wider;
uniform bool shaded;
varying vec3 tilt;${COLORS}${LIGHT}
void main() {
    vec4 seen = modelViewMatrix * vec4(position, 1.0);
    vec3 facing = normalMatrix * normal;
    facing = dot(facing, seen.xyz) > 0.0 ? -facing : facing;
    tilt = facing;
    shown = mode == 4 ? 0.5 + 0.5 * facing : colour();
    if (shaded) shown *= light(normalize(facing));
    gl_Position = projectionMatrix * seen;
    gl_PointSize = clamp(size * wider * (width > 0.0 ? width : spacing) * scale / max(gl_Position.w, 1e-30), 1.5, 64.0);
}`;
/* A disc lies in its surface, so that seen from the side it is narrow; at most so much that it stays to be seen. */
const FRAGMENT = `
varying vec3 shown, tilt;
void main() {
    vec2 off = gl_PointCoord - 0.5;
    float deep = dot(vec2(off.x, -off.y), tilt.xy) / max(tilt.z, 0.4);
    if (dot(off, off) + deep * deep > 0.25) discard;
    gl_FragColor = vec4(shown, 1.0);
}`;
const FACE_VERTEX = `${COLORS}
varying vec3 seen;
void main() {
    seen = (modelViewMatrix * vec4(position, 1.0)).xyz;
    shown = colour();
    gl_Position = projectionMatrix * vec4(seen, 1.0);
}`;
const FACE_FRAGMENT = `
uniform int mode;
uniform bool lit;
varying vec3 seen, shown;${LIGHT}
void main() {
    vec3 facing = normalize(cross(dFdx(seen), dFdy(seen)));
    facing = facing.z < 0.0 ? -facing : facing;
    gl_FragColor = vec4(mode == 4 ? 0.5 + 0.5 * facing : shown * (lit ? light(facing) : 1.0), 1.0);
}`;

function material() {
    const vectors = Array.from({ length: 5 }, () => new Vector3());
    return new ShaderMaterial({ vertexShader: VERTEX, fragmentShader: FRAGMENT, uniforms: {
        size: { value: 1 }, spacing: { value: 1 }, scale: { value: 1 }, wider: { value: 1 }, low: { value: 0 }, high: { value: 1 }, mode: { value: 0 },
        shaded: { value: false }, lit: { value: false }, plain: { value: new Color(0x888888) }, stop: { value: vectors } } });
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
    return { group, wire, wires: group.children[1],
        share() {
            for (const name of ['position', 'tint', 'value'])
                if (points.attributes[name]) geometry.setAttribute(name, points.attributes[name]);
        },
        free: () => [geometry, skin, wire].forEach((one) => one.dispose()) };
}

/** Makes what is drawn of a cloud (as cloud.js reads it). set*() change how; free() gives the card's memory back. */
export function makePoints(cloud) {
    const geometry = new BufferGeometry(), look = material(), sphere = sphereOf(cloud);
    const few = cloud.n > MOVING_MIN && !cloud.faces ? sample(cloud.n) : null;
    geometry.setAttribute('position', new BufferAttribute(cloud.positions, 3));
    if (cloud.colors) geometry.setAttribute('tint', new BufferAttribute(cloud.colors, 3, true));
    if (cloud.normals) geometry.setAttribute('normal', new BufferAttribute(cloud.normals, 3));
    geometry.boundingSphere = sphere;
    const mesh = cloud.faces ? meshOf(cloud.faces, geometry, look) : null, root = mesh ? mesh.group : new Points(geometry, look);
    mesh?.share();
    const { uniforms } = look;
    return {
        root, sphere, positions: cloud.positions,
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
        /* How wide discs are: size times the width of each, or the spacing as long as widths are not there. */
        setSize(size, spacing) {
            [uniforms.size.value, uniforms.spacing.value] = [size, spacing];
        },
        /* Pixels of a unit at distance 1; distance: of the eye from what it looks at. */
        setScale(scale, distance) {
            uniforms.scale.value = scale;
            if (mesh) mesh.wire.opacity = WIRE * Math.min(1, uniforms.spacing.value * scale / distance / WIRE_PIXELS);
        },
        setWires(wires) {
            if (mesh) mesh.wires.visible = wires;
        },
        free() {
            geometry.dispose();
            look.dispose();
            if (mesh) mesh.free();
        },
    };
}
