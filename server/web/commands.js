/* A request as commands that can be pasted elsewhere. A key is never among them: $VORONOID_KEY stands for it. */

import { query } from './query.js';

/** A word that a shell takes as it is written. */
export const shell = (word) => (/^[\w@%+=:,./-]+$/.test(word) ? word : `'${word.replaceAll("'", "'\\''")}'`);

const address = ({ root, process, values }) => new URL(`v1/${process}?${query(values)}`, root).href.replace(/\?$/, '');
const named = (word) => (word.startsWith('-') ? `./${word}` : word);

const several = (request) => Object.keys(request.others).length > 0;
const inputs = (request) => ({ file: request.file, ...request.others });

function curl(request) {
    const parts = ['curl -sS --fail-with-body -X POST'];
    if (request.key) parts.push('-H "Authorization: Bearer $VORONOID_KEY"');
    if (several(request)) /* in quotes of curl's own, for which a comma ends a name */
        Object.entries(inputs(request)).forEach(([name, file]) => parts.push(`-F ${shell(`${name}=@"${file.replace(/[\\"]/g, '\\$&')}"`)}`));
    else parts.push(`--data-binary ${shell(`@${request.file}`)}`);
    parts.push(`-o ${shell(named(request.out))}`, shell(address(request)));
    return parts.join(' \\\n    ');
}

function cli(request) {
    const parts = [`voronoid ${request.process} ${shell(named(request.file))}`];
    for (const [name, value] of Object.entries({ ...request.others, ...request.values }))
        parts.push(`--${name.replace(/[A-Z]/g, (one) => `-${one.toLowerCase()}`)}=${shell(value)}`);
    parts.push(`--server ${shell(String(request.root).replace(/\/$/, ''))}`, `-o ${shell(named(request.out))}`);
    return parts.join(' \\\n    ');
}

function js(request) {
    const headers = request.key ? '\n    headers: { Authorization: `Bearer ${process.env.VORONOID_KEY}` },' : '';
    const form = several(request) ? `const body = new FormData();
for (const [name, file] of Object.entries(${JSON.stringify(inputs(request))}))
    body.append(name, new Blob([await readFile(file)]), file);
` : `const body = await readFile(${JSON.stringify(request.file)});
`;
    return `import { readFile, writeFile } from 'node:fs/promises';

${form}const answer = await fetch(${JSON.stringify(address(request))}, {
    method: 'POST',${headers}
    body,
});
if (!answer.ok) throw new Error((await answer.json()).detail);
await writeFile(${JSON.stringify(request.out)}, new Uint8Array(await answer.arrayBuffer()));
`;
}

/* Python has no forms; this one's boundary stands in no file. */
const pythonForm = (request) => `edge, body = uuid.uuid4().hex, b""
for name, path in ${JSON.stringify(inputs(request))}.items():
    with open(path, "rb") as cloud:
        body += f'--{edge}\\r\\nContent-Disposition: form-data; name="{name}"; filename="{name}"\\r\\n\\r\\n'.encode() + cloud.read() + b"\\r\\n"
body += f"--{edge}--\\r\\n".encode()
`;

function python(request) {
    const headers = [...(several(request) ? ['"Content-Type": f"multipart/form-data; boundary={edge}"'] : []),
        ...(request.key ? ['"Authorization": "Bearer " + os.environ["VORONOID_KEY"]'] : [])];
    const body = several(request) ? pythonForm(request) : `with open(${JSON.stringify(request.file)}, "rb") as cloud:
    body = cloud.read()
`;
    return `import json${request.key ? ', os' : ''}, urllib.error, urllib.request${several(request) ? ', uuid' : ''}

${body}request = urllib.request.Request(${JSON.stringify(address(request))}, body${headers.length ? `, {${headers.join(', ')}}` : ''})
try:
    with urllib.request.urlopen(request) as answer, open(${JSON.stringify(request.out)}, "wb") as out:
        out.write(answer.read())
except urllib.error.HTTPError as error:
    raise SystemExit(json.load(error)["detail"])
`;
}

const LANGUAGES = { curl, cli, js, python };

/** request: {root, process, values, file, others (files by the names of their inputs), out, key (whether one is used)}; language: curl, cli, js or python. */
export const command = (language, request) => LANGUAGES[language](request);
