/* A request as commands that can be pasted elsewhere. A key is never among them: $VORONOID_KEY stands for it. */

import { query } from './query.js';

/** A word that a shell takes as it is written. */
export const shell = (word) => (/^[\w@%+=:,./-]+$/.test(word) ? word : `'${word.replaceAll("'", "'\\''")}'`);

const address = ({ root, process, values }) => new URL(`v1/${process}?${query(values)}`, root).href.replace(/\?$/, '');
const named = (word) => (word.startsWith('-') ? `./${word}` : word);

function curl(request) {
    const parts = ['curl -sSf -X POST'];
    if (request.key) parts.push('-H "Authorization: Bearer $VORONOID_KEY"');
    parts.push(`--data-binary ${shell(`@${request.file}`)}`, `-o ${shell(named(request.out))}`, shell(address(request)));
    return parts.join(' \\\n    ');
}

function cli(request) {
    const parts = [`voronoid ${request.process} ${shell(named(request.file))}`];
    for (const [name, value] of Object.entries(request.values))
        parts.push(`--${name}=${shell(value)}`);
    parts.push(`--server ${shell(String(request.root).replace(/\/$/, ''))}`, `-o ${shell(named(request.out))}`);
    return parts.join(' \\\n    ');
}

function js(request) {
    const headers = request.key ? '\n    headers: { Authorization: `Bearer ${process.env.VORONOID_KEY}` },' : '';
    return `import { readFile, writeFile } from 'node:fs/promises';

const answer = await fetch(${JSON.stringify(address(request))}, {
    method: 'POST',${headers}
    body: await readFile(${JSON.stringify(request.file)}),
});
if (!answer.ok) throw new Error((await answer.json()).detail);
await writeFile(${JSON.stringify(request.out)}, new Uint8Array(await answer.arrayBuffer()));
`;
}

function python(request) {
    const headers = request.key ? ', {"Authorization": "Bearer " + os.environ["VORONOID_KEY"]}' : '';
    return `import json${request.key ? ', os' : ''}, urllib.error, urllib.request

with open(${JSON.stringify(request.file)}, "rb") as cloud:
    request = urllib.request.Request(${JSON.stringify(address(request))}, cloud.read()${headers})
try:
    with urllib.request.urlopen(request) as answer, open(${JSON.stringify(request.out)}, "wb") as out:
        out.write(answer.read())
except urllib.error.HTTPError as error:
    raise SystemExit(json.load(error)["detail"])
`;
}

const LANGUAGES = { curl, cli, js, python };

/** request: {root, process, values, file, out, key (whether one is used)}; language: curl, cli, js or python. */
export const command = (language, request) => LANGUAGES[language](request);
