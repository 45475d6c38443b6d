/* A cloud as three.js draws it: discs as large as a spacing, shaded by normals; a mesh with its wires. */
import { BufferAttribute, BufferGeometry, Color, DoubleSide, Group, Mesh, MeshPhongMaterial, Points, ShaderMaterial, Sphere, Vector3 }
    from 'three';
import { MODES, stops } from './palette.js';

/** Of larger clouds so many points are drawn while the view moves. */
export const MOVING_MAX = 300000;

const VERTEX = `
attribute vec3 tint;
attribute float value;
uniform float size, scale, low, high;
uniform int mode;
uniform bool shaded;
uniform vec3 plain;
uniform vec3 stop[5];
varying vec3 shown;
vec3 ramp(float t) {
    float at = clamp(t, 0.0, 1.0) * 4.0;
    vec3 color = stop[0];
    for (int k = 0; k < 4; k++) color = mix(color, stop[k + 1], clamp(at - float(k), 0.0, 1.0));
    return color;
}
void main() {
    vec4 seen = modelViewMatrix * vec4(position, 1.0);
    vec3 facing = normalMatrix * normal;
    facing = dot(facing, seen.xyz) > 0.0 ? -facing : facing;
    shown = plain;
    if (mode == 1) shown = tint;
    if (mode == 2 || mode == 3) shown = ramp((value - low) / max(high - low, 1e-30));
    if (mode == 4) shown = 0.5 + 0.5 * facing;
    if (shaded) shown *= 0.4 + 0.65 * clamp(dot(normalize(facing), normalize(vec3(0.25, 0.35, 1.0))), 0.0, 1.0);
    gl_Position = projectionMatrix * seen;
    gl_PointSize = clamp(size * scale / max(gl_Position.w, 1e-30), 1.5, 64.0);
}`;
const FRAGMENT = `
varying vec3 shown;
void main() {
    vec2 off = gl_PointCoord - 0.5;
    if (dot(off, off) > 0.25) discard;
    gl_FragColor = vec4(shown, 1.0);
}`;

function material() {
    const vectors = Array.from({ length: 5 }, () => new Vector3());
    return new ShaderMaterial({ vertexShader: VERTEX, fragmentShader: FRAGMENT, uniforms: {
        size: { value: 1 }, scale: { value: 1 }, low: { value: 0 }, high: { value: 1 }, mode: { value: 0 },
        shaded: { value: false }, plain: { value: new Color(0x888888) }, stop: { value: vectors } } });
}

/* One point of each run of as many, taken by a fixed generator: rows of a scanner would else show as stripes. */
function sample(n) {
    const out = new Uint32Array(MOVING_MAX), stride = n / MOVING_MAX;
    for (let i = 0, state = 1; i < MOVING_MAX; i++) {
        state = (Math.imul(state, 1664525) + 1013904223) >>> 0;
        out[i] = Math.min(n - 1, Math.floor((i + state / 4294967296) * stride));
    }
    return new BufferAttribute(out, 1);
}

function sphereOf({ low, high }) {
    const [from, to] = [new Vector3(...low), new Vector3(...high)];
    return new Sphere(from.clone().add(to).multiplyScalar(0.5), Math.max(from.distanceTo(to) / 2, 1e-30));
}

function meshOf(cloud, sphere) {
    const geometry = new BufferGeometry(), group = new Group();
    geometry.setAttribute('position', new BufferAttribute(cloud.positions, 3));
    geometry.setIndex(new BufferAttribute(cloud.faces, 1));
    geometry.boundingSphere = sphere;
    const skin = new MeshPhongMaterial({ color: 0xb8bcc4, flatShading: true, side: DoubleSide, shininess: 8, polygonOffset: true,
        polygonOffsetFactor: 1, polygonOffsetUnits: 1 });
    const wire = new MeshPhongMaterial({ color: 0x20242c, wireframe: true, side: DoubleSide, transparent: true, opacity: 0.4 });
    group.add(new Mesh(geometry, skin), new Mesh(geometry, wire));
    return { group, wires: group.children[1], free: () => [geometry, skin, wire].forEach((one) => one.dispose()) };
}

/** Makes what is drawn of a cloud (as cloud.js reads it). set*() change how; free() gives the card's memory back. */
export function makePoints(cloud) {
    const geometry = new BufferGeometry(), look = material(), sphere = sphereOf(cloud);
    const few = cloud.n > MOVING_MAX ? sample(cloud.n) : null;
    geometry.setAttribute('position', new BufferAttribute(cloud.positions, 3));
    if (cloud.colors) geometry.setAttribute('tint', new BufferAttribute(cloud.colors, 3, true));
    if (cloud.normals) geometry.setAttribute('normal', new BufferAttribute(cloud.normals, 3));
    geometry.boundingSphere = sphere;
    const points = new Points(geometry, look), root = new Group();
    const mesh = cloud.faces ? meshOf(cloud, sphere) : null;
    root.add(points);
    if (mesh) root.add(mesh.group);
    return {
        root, sphere, mesh: Boolean(mesh),
        setMoving(moving) {
            if (few) geometry.setIndex(moving ? few : null);
        },
        setMode(mode, low, high) {
            look.uniforms.mode.value = MODES[mode];
            [look.uniforms.low.value, look.uniforms.high.value] = [low, high];
            stops(mode).forEach((color, k) => look.uniforms.stop.value[k].fromArray(color));
        },
        setNormals(normals) {
            if (!geometry.attributes.normal) geometry.setAttribute('normal', new BufferAttribute(normals, 3));
        },
        setValues(values) {
            geometry.setAttribute('value', new BufferAttribute(values, 1));
        },
        setShaded(shaded) {
            look.uniforms.shaded.value = shaded && Boolean(geometry.attributes.normal);
        },
        setPlain: (color) => look.uniforms.plain.value.set(color),
        setSize: (size) => { look.uniforms.size.value = size; },
        setScale: (scale) => { look.uniforms.scale.value = scale; },
        /* Of a mesh the triangles, or its points alone, as colours need them. */
        setTriangles(triangles, wires) {
            if (!mesh) return;
            mesh.group.visible = triangles;
            points.visible = !triangles;
            mesh.wires.visible = wires;
        },
        free() {
            geometry.dispose();
            look.dispose();
            if (mesh) mesh.free();
        },
    };
}
