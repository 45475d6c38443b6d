#!/usr/bin/env node
/* The page's modules that need no browser: what a PLY holds, who is nearest, and commands as shells and languages read them. */
const { execFileSync } = require('child_process');
const { mkdtempSync, rmSync, writeFileSync } = require('fs');
const { tmpdir } = require('os');

const folder = mkdtempSync(`${tmpdir()}/page-`);
let done = 0, failed = 0;

function load(name) {
    const out = `${folder}/${name}.cjs`;
    execFileSync('esbuild', [`server/web/${name}.js`, '--bundle', '--format=cjs', '--log-level=error', `--outfile=${out}`]);
    return require(out);
}

function ok(isTrue, sentence, why) {
    console.log(`${isTrue ? 'ok' : 'not ok'} ${++done} - ${sentence}`);
    if (!isTrue) {
        failed++;
        console.log(`# ${JSON.stringify(why)}`);
    }
}

const equal = (got, wanted, sentence) => ok(JSON.stringify(got) === JSON.stringify(wanted), sentence, { got, wanted });

function refusal(work) {
    try {
        work();
    } catch (error) {
        return error.message;
    }
    return 'none';
}

const { firstOf, readPly } = load('ply');
const bytes = (text) => new TextEncoder().encode(text).buffer;

function ascii() {
    const cloud = readPly(bytes('ply\r\nformat ascii 1.0\r\ncomment by hand\r\nelement junk 2\r\nproperty list uchar int some\r\nelement vertex 4\r\n'
        + 'property float x\r\nproperty list uchar float more\r\nproperty double y\r\nproperty float z\r\nproperty float red\r\nproperty float green\r\n'
        + 'property float blue\r\nelement face 1\r\nproperty list uchar int vertex_indices\r\nend_header\r\n2 7 8\r\n0\r\n0 1 9.5 0 0 1 0 0\r\n'
        + '2 0 0 0 0 1 0\r\n2 2 1 1 4 0 0 0 0.5\r\n0 0 4 0 0 0 0\r\n4 0 1 2 3\r\n'));
    equal([cloud.n, cloud.origin, [...cloud.positions]], [4, [1, 2, 0], [-1, -2, 0, 1, -2, 0, 1, 2, 0, -1, 2, 0]],
        'an ASCII file is read, past elements and lists that it does not need, relative to its middle');
    equal([...cloud.colors], [255, 0, 0, 0, 255, 0, 0, 0, 128, 0, 0, 0], 'colours that are floats go to 1');
    equal([...cloud.faces], [0, 1, 2, 0, 2, 3], 'a face of four corners is two triangles');
    equal([cloud.low, cloud.high], [[-1, -2, 0], [1, 2, 0]], 'and its box is told');
    const other = readPly(bytes('\u{feff}ply \nformat ascii 1.0\nelement Vertex 2\nproperty float X\nproperty float Y\nproperty float Z\n'
        + 'property uchar r\nproperty uchar g\nproperty uchar b\nproperty float q\nend_header\n0 1 2 3 4 5 -nan(ind)\n2 1 0 6 7 8 1.#QNAN\n'), [0, 0, 0]);
    equal([[...other.positions], [...other.colors]], [[0, 1, 2, 2, 1, 0], [3, 4, 5, 6, 7, 8]], 'so is one as other programs write them');
    const red = readPly(bytes('ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\nproperty float red\n'
        + 'property uchar r\nproperty uchar g\nproperty uchar b\nend_header\n0 1 2 3 4 5 6\n'));
    equal(red.colors, null, 'a red alone is no colour, nor are those beside it');
}

/* Points 1 mm apart, 5,000 km from zero. */
function far(little) {
    const n = 100, head = `ply\nformat binary_${little ? 'little' : 'big'}_endian 1.0\nelement vertex ${n}\nproperty double x\nproperty double y\n`
        + 'property double z\nproperty uchar other\nend_header\n';
    const buffer = new ArrayBuffer(head.length + 25 * n), view = new DataView(buffer);
    new Uint8Array(buffer).set(new TextEncoder().encode(head));
    for (let i = 0; i < n; i++)
        [5e6 + i / 1000, -5e6, 1].forEach((value, k) => view.setFloat64(head.length + 25 * i + 8 * k, value, little));
    return buffer;
}

function farAway() {
    for (const little of [true, false]) {
        const { positions } = readPly(far(little));
        let worst = 0;
        for (let i = 1; i < 100; i++) worst = Math.max(worst, Math.abs(positions[3 * i] - positions[3 * i - 3] - 0.001));
        ok(worst < 1e-8, `1 mm is 1 mm 5,000 km from zero, ${little ? 'little' : 'big'} endian: float32 would make 0.5 m of it`, worst);
    }
    const again = readPly(far(true), [5e6, -5e6, 0]);
    ok(Math.abs(again.positions[3 * 99] - 0.099) < 1e-8 && again.positions[2] === 1, 'a second cloud is read in the frame of the first', again.positions[0]);
}

function refusals() {
    equal(refusal(() => readPly(bytes('hello'))), 'This is not a PLY file.', 'what is no PLY is refused');
    equal(refusal(() => readPly(far(true).slice(0, -1))), 'The file ends before its last row.', 'and a file that ends early');
    equal(refusal(() => readPly(bytes('ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nend_header\n1\n'))), 'The vertices have no x, y and z.',
        'and points without a coordinate');
    equal(refusal(() => readPly(bytes('ply\nformat ascii 1.0\nelement vertex 1\nproperty quad x\nend_header\n1\n'))),
        'PLY has no type "quad".', 'and a type that there is not');
    const sifted = readPly(bytes('ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 1\n'
        + 'property list uchar int vertex_index\nend_header\n0 0 0\nnan 0 0\n2 0 0\n3 0 1 2\n'));
    equal([sifted.n, sifted.left, [...sifted.positions], sifted.faces], [2, 1, [-1, 0, 0, 1, 0, 0], null],
        'a point that is not finite is left out, and the triangle that hangs on it');
}

/* A file that comes in pieces. */
function early() {
    const whole = new Uint8Array(far(true)), rows = whole.length - 100 * 25;
    equal(firstOf(whole.subarray(0, rows + 40 * 25 - 1), 40), null, 'points that are not there yet are not shown');
    const first = readPly(firstOf(whole.subarray(0, rows + 40 * 25), 40), [5e6, -5e6, 1]);
    equal([first.n, Math.round(1e6 * first.positions[3 * 39]), first.positions[2]], [40, 39000, 0], 'the first points of a file are a cloud before the others come');
    equal(firstOf(whole, 100), null, 'all of them are no part');
}

/* Oracle: every pair. */
function neighbours() {
    const { makeTree, nearest } = load('tree'), k = 5;
    let state = 1, wrong = 0;
    const draw = () => (state = (Math.imul(state, 1664525) + 1013904223) >>> 0) / 4294967296;
    for (const n of [1, 2, 12, 13, 400, 1000]) {
        const xyz = Float32Array.from({ length: 3 * n }, () => Math.round(draw() * 40) / 40), tree = makeTree(xyz); /* with ties and doubles */
        for (let q = 0; q < 60; q++) {
            const [x, y, z] = [draw(), draw(), draw()], found = new Uint32Array(k), squares = new Float64Array(k);
            nearest(tree, x, y, z, found, squares);
            const all = [];
            for (let i = 0; i < n; i++) all.push((xyz[3 * i] - x) ** 2 + (xyz[3 * i + 1] - y) ** 2 + (xyz[3 * i + 2] - z) ** 2);
            all.sort((a, b) => a - b);
            for (let i = 0; i < Math.min(k, n); i++) wrong += Math.abs(all[i] - squares[i]) > 1e-12;
            if (n < k) wrong += squares[n] !== Infinity;
        }
        const places = new Set(tree.index);
        wrong += places.size !== n;
    }
    equal(wrong, 0, 'the tree finds the nearest points that a search through all finds');
}

function normals() {
    const { leastSpread } = load('tree');
    const xyz = Float32Array.from([0, 0, 0, 1, 0, 2, 0, 1, 0, 1, 1, 2, 0.5, 0.5, 1]), to = new Float32Array(3);
    leastSpread({ xyz }, [0, 1, 2, 3, 4], 5, to, 0);
    const along = Math.abs(to[0] * 2 - to[2]) / Math.sqrt(5);
    ok(Math.abs(along - 1) < 1e-6, 'the normal of points on a plane is the normal of the plane', [...to]);
}

/* The worker without a browser: what it answers to each message. */
async function discs() {
    const answers = [];
    global.self = { postMessage: (answer) => answers.push(answer) };
    load('cloud_worker');
    const rows = [];
    for (let y = 0; y < 40; y++) for (let x = 0; x < 120; x++) rows.push(`${x} ${3 * y} 0`);
    rows.push('60 60 500');
    const buffer = bytes(`ply\nformat ascii 1.0\nelement vertex ${rows.length}\nproperty float x\nproperty float y\nproperty float z\nend_header\n${rows.join('\n')}\n`);
    await self.onmessage({ data: { call: 1, what: 'read', number: 1, buffer } });
    await self.onmessage({ data: { call: 2, what: 'normals', number: 1 } });
    const { widths, normals } = answers[1].answer, middle = 20 * 120 + 60;
    equal([widths[middle], Math.abs(normals[3 * middle + 2])], [3, 1], 'a point on a line of a scanner is drawn as wide as the way to the next line');
    ok(widths.at(-1) < 6, 'and one that is alone not so wide that it hides others', widths.at(-1));
    await turns(answers);
    delete global.self;
}

/* While a large cloud is measured, another one is read; one that is let go is measured no more. */
async function turns(answers) {
    const n = 120000, head = `ply\nformat binary_little_endian 1.0\nelement vertex ${n}\nproperty float x\nproperty float y\nproperty float z\nend_header\n`;
    const buffer = new ArrayBuffer(head.length + 12 * n), view = new DataView(buffer);
    new Uint8Array(buffer).set(new TextEncoder().encode(head));
    for (let i = 0; i < n; i++) [i % 400, Math.floor(i / 400), 0].forEach((value, k) => view.setFloat32(head.length + 12 * i + 4 * k, value, true));
    answers.length = 0;
    await self.onmessage({ data: { call: 1, what: 'read', number: 2, buffer } });
    const measured = self.onmessage({ data: { call: 2, what: 'spacing', number: 2 } });
    await self.onmessage({ data: { call: 3, what: 'read', number: 3, buffer: far(true) } });
    equal(answers.map((one) => one.call), [1, 3], 'while a large cloud is measured, another one is read');
    await self.onmessage({ data: { call: 4, what: 'drop', number: 2 } });
    await measured;
    equal(answers.map((one) => [one.call, one.error]).at(-1), [2, 'The cloud was removed.'], 'and one that is let go is measured no more');
}

/* Points of a view that is turned, in a browser that draws as many thousands of them in 1 ms. */
function pace() {
    const { MOVING_MAX, MOVING_MIN, nextBudget } = load('pace');
    const settled = (rate) => {
        let budget = MOVING_MAX;
        for (let k = 0; k < 40; k++) budget = nextBudget(budget, budget / (1000 * rate));
        return budget;
    };
    equal([settled(20), settled(0.1)], [MOVING_MAX, MOVING_MIN], 'a fast browser draws as many points as it may, a slow one as many as it must');
    const ms = [0.7, 1, 2, 3].map((rate) => settled(rate) / (1000 * rate));
    ok(ms.every((one) => one >= 30 && one <= 80), 'and others as many as take 30 to 80 ms', ms);
}

function commands() {
    const { command, shell } = load('commands'), words = ["it's", 'two words', '$HOME `id` "x"', '-n', '', 'a\nb', '*?[!]', '\\'];
    const said = execFileSync('/bin/sh', ['-c', `printf '%s\\0' ${words.map(shell).join(' ')}`]).toString();
    equal(said.split('\0').slice(0, -1), words, 'a shell reads each quoted word as it was');
    const request = { root: 'http://127.0.0.1:8080/', process: 'resample', values: { points: '5000', density: 'attribute:the "x"' }, file: "-it's.ply",
        others: {}, out: 'o.ply', key: true };
    for (const language of ['curl', 'js', 'python']) {
        const text = command(language, request);
        ok(text.includes('VORONOID_KEY'), `${language} takes the key from where it is kept`, text);
    }
    writeFileSync(`${folder}/curl`, '#!/bin/sh\nprintf "%s\\0" "$@"\n', { mode: 0o755 });
    const given = execFileSync('/bin/sh', ['-c', command('curl', request)], { env: { PATH: `${folder}:${process.env.PATH}`, VORONOID_KEY: 'a b' } }).toString().split('\0');
    equal(given.slice(4, -1), ['-H', 'Authorization: Bearer a b', '--data-binary', "@-it's.ply", '-o', 'o.ply',
        'http://127.0.0.1:8080/v1/resample?points=5000&density=attribute%3Athe%20%22x%22'], 'curl gets what the request is');
    const two = { ...request, process: 'measure', values: {}, others: { reference: 'a "b",c;.ply' }, out: 'o.json' };
    const forms = execFileSync('/bin/sh', ['-c', command('curl', two)], { env: { PATH: `${folder}:${process.env.PATH}`, VORONOID_KEY: 'k' } }).toString().split('\0');
    equal(forms.slice(6, 10), ['-F', `file=@"-it's.ply"`, '-F', 'reference=@"a \\"b\\",c;.ply"'], 'and a form of two files, whose names end where they should');
    for (const one of [request, two]) {
        writeFileSync(`${folder}/it.mjs`, command('js', one));
        execFileSync('node', ['--check', `${folder}/it.mjs`]);
        writeFileSync(`${folder}/it.py`, command('python', one));
        execFileSync('python3', ['-c', `import ast; ast.parse(open("${folder}/it.py").read())`]);
    }
    ok(true, 'the programs are ones');
    const options = command('cli', { ...request, values: { maxAspect: '4', sigmaN: '20' } });
    ok(options.includes('--max-aspect=4') && options.includes('--sigma-n=20'), 'options are written as the command line writes them', options);
}

async function main() {
    try {
        for (const part of [ascii, farAway, refusals, early, neighbours, normals, discs, pace, commands]) await part();
    } finally {
        rmSync(folder, { recursive: true });
    }
    console.log(`1..${done}`);
    process.exit(failed ? 1 : 0);
}

main();
