// usage: node draco3d.js FILE.drc OUT.ply [FILE.drc OUT.ply ...]
// Decodes Draco point clouds with npm's draco3d, as a page would, into binary PLY: positions as the file has them, normals
// and colours. Prints a line for each: the origin that the metadata tells, as X,Y,Z, or 0,0,0 without one.
'use strict';
const fs = require('fs');
const draco3d = require('draco3d');

const keys = ['voronoid.origin.x', 'voronoid.origin.y', 'voronoid.origin.z'];

function originOf(draco, decoder, cloud) {
    const metadata = decoder.GetMetadata(cloud);
    const querier = new draco.MetadataQuerier();
    const names = [];
    for (let i = 0; metadata.ptr !== 0 && i < querier.NumEntries(metadata); i++) names.push(querier.GetEntryName(metadata, i));
    const has = keys.every((key) => names.includes(key));
    const origin = keys.map((key) => (has ? querier.GetDoubleEntry(metadata, key) : 0));
    draco.destroy(querier);
    return origin;
}

// The values of an attribute: an array of `components` numbers a point.
function valuesOf(draco, decoder, cloud, attribute) {
    const values = new draco.DracoFloat32Array();
    if (!decoder.GetAttributeFloatForAllPoints(cloud, attribute, values)) throw new Error('an attribute has no values');
    const out = new Float32Array(values.size());
    for (let i = 0; i < out.length; i++) out[i] = values.GetValue(i);
    draco.destroy(values);
    return { out, components: attribute.num_components() };
}

function plyOf(n, columns) {
    let head = `ply\nformat binary_little_endian 1.0\nelement vertex ${n}\n`;
    let size = 0;
    for (const column of columns) {
        for (const name of column.names) head += `property ${column.isByte ? 'uchar' : 'float'} ${name}\n`;
        size += column.names.length * (column.isByte ? 1 : 4);
    }
    const body = Buffer.alloc(n * size);
    let at = 0;
    for (let i = 0; i < n; i++) {
        for (const { names, values, isByte } of columns) {
            for (let c = 0; c < names.length; c++) {
                const value = values.out[i * values.components + c];
                // Colours come as floats of 0 to 1, because they are normalised integers in the file.
                at = isByte ? body.writeUInt8(Math.round(value * 255), at) : body.writeFloatLE(value, at);
            }
        }
    }
    return Buffer.concat([Buffer.from(`${head}end_header\n`), body]);
}

function decode(draco, input, output) {
    const bytes = fs.readFileSync(input);
    const buffer = new draco.DecoderBuffer();
    const decoder = new draco.Decoder();
    const cloud = new draco.PointCloud();
    buffer.Init(new Int8Array(bytes), bytes.length);
    const status = decoder.DecodeBufferToPointCloud(buffer, cloud);
    if (!status.ok() || cloud.ptr === 0) throw new Error(`${input}: ${status.error_msg()}`);
    const columns = [];
    for (const [kind, names, isByte] of [[draco.POSITION, ['x', 'y', 'z'], false], [draco.NORMAL, ['nx', 'ny', 'nz'], false],
        [draco.COLOR, ['red', 'green', 'blue'], true]]) {
        const id = decoder.GetAttributeId(cloud, kind);
        if (id < 0) continue;
        columns.push({ names, isByte, values: valuesOf(draco, decoder, cloud, decoder.GetAttribute(cloud, id)) });
    }
    fs.writeFileSync(output, plyOf(cloud.num_points(), columns));
    console.log(originOf(draco, decoder, cloud).join(','));
    for (const owned of [cloud, decoder, buffer]) draco.destroy(owned);
}

draco3d.createDecoderModule({}).then((draco) => {
    const files = process.argv.slice(2);
    if (files.length === 0 || files.length % 2 !== 0) throw new Error('usage: node draco3d.js FILE.drc OUT.ply ...');
    for (let i = 0; i < files.length; i += 2) decode(draco, files[i], files[i + 1]);
}).catch((error) => {
    console.error(String(error));
    process.exitCode = 1;
});
