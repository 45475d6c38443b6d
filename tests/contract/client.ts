// A client in the types that openapi-typescript makes of openapi.yaml: what compiles here compiles for its users.
// usage: node client.js URL, of a daemon: lists the processes, posts a cloud, reads its events, its status and its
// result; fails when something of that is not as the types say.
import type { components, operations, paths } from "./openapi";

type ProcessList = paths["/v1/processes"]["get"]["responses"][200]["content"]["application/json"];
type StatusInfo = operations["resample"]["responses"][201]["content"]["application/json"];
type Query = NonNullable<operations["resample"]["parameters"]["query"]>;
type EventLine = components["schemas"]["eventLine"];
type Report = components["schemas"]["report"];
type Problem = components["schemas"]["problem"];

declare const process: { argv: string[]; exitCode: number };

async function json<T>(answer: Response): Promise<T> {
    if (answer.ok) return (await answer.json()) as T;
    const problem = (await answer.json()) as Problem;
    throw new Error(`${problem.status} ${problem.title}: ${problem.detail ?? ""}`);
}

async function processNames(url: string): Promise<string[]> {
    const p = await json<ProcessList>(await fetch(`${url}/v1/processes`));
    return p.processes.map((each) => each.id);
}

async function submit(url: string, cloud: Blob, query: Query): Promise<StatusInfo> {
    const parameters = new URLSearchParams();
    for (const [name, value] of Object.entries(query)) parameters.set(name, String(value));
    return json(await fetch(`${url}/v1/resample?${parameters}`, {
        method: "POST",
        headers: { "Content-Type": "application/ply", Prefer: "respond-async" },
        body: cloud,
    }));
}

async function* events(url: string, job: StatusInfo): AsyncGenerator<EventLine> {
    const answer = await fetch(`${url}/v1/jobs/${job.jobID}/events`, { headers: { Accept: "application/x-ndjson" } });
    const lines = (await answer.text()).split("\n");
    for (const line of lines) if (line !== "") yield JSON.parse(line) as EventLine;
}

// What the client learns of one event, by its kind.
function told(line: EventLine): string {
    switch (line.event) {
        case "status":
            return `${line.data.status}, attempt ${line.data.voronoid.attempt}`;
        case "progress":
            return `${line.data.progress} %, delta ${line.data.delta?.toFixed(4) ?? "not known"}`;
        case "replaced":
            return `attempt ${line.data.attempt}`;
        case "end":
            return `${line.data.status}: ${line.data.href}`;
    }
}

// What must not compile: were a type any, or an object without members, these lines would be errors.
export function refused(status: StatusInfo, line: EventLine, report: Report): void {
    // @ts-expect-error a number of points is no text
    const points: Query = { points: "many" };
    // @ts-expect-error there is no such order
    const order: Query = { order: "sideways" };
    // @ts-expect-error there is no such status
    const isOver = status.status === "over";
    // @ts-expect-error a delta may be null
    const delta: number = report.delta;
    // @ts-expect-error an event has no data before its kind is known
    const progress = line.data.progress;
    void [points, order, isOver, delta, progress];
}

function sphere(n: number): Blob {
    const points = Array.from({ length: n }, (_, i) => {
        const z = 1 - (2 * (i + 0.5)) / n;
        const [r, angle] = [Math.sqrt(1 - z * z), i * 2.399963229728653];
        return `${r * Math.cos(angle)} ${r * Math.sin(angle)} ${z}\n`;
    });
    return new Blob([`ply\nformat ascii 1.0\nelement vertex ${n}\n`,
        "property float x\nproperty float y\nproperty float z\nend_header\n", ...points]);
}

function expect(is: boolean, what: string): void {
    if (!is) throw new Error(`not so: ${what}`);
}

async function main(url: string): Promise<void> {
    expect((await processNames(url)).includes("resample"), "resample is offered");
    const job = await submit(url, sphere(2000), { points: 500, iterations: 5, order: "spatial", filters: ["thin"] });
    const kinds = new Set<string>();
    for await (const line of events(url, job)) {
        kinds.add(line.event);
        console.log(`${line.id} ${line.event}: ${told(line)}`);
    }
    expect(kinds.has("status") && kinds.has("progress") && kinds.has("end"), "every kind of event came");
    const status = await json<StatusInfo>(await fetch(`${url}/v1/jobs/${job.jobID}`));
    expect(status.status === "successful" && status.voronoid.metrics?.iteration === 5, "the job ended well");
    const report = await json<Report>(await fetch(`${url}/v1/jobs/${job.jobID}/results/report`));
    expect(report.points.out === 500 && report.parameters["points"] === 500, "the report says so");
}

main(process.argv[2] ?? "").catch((error: unknown) => {
    console.error(String(error));
    process.exitCode = 1;
});
