/* The SharedWorker that holds the stream of all tabs. A tab says {root, key, watch: id, position} or {leave: id} and gets {event, data};
 * {gone: true} when it is closed. Tabs with different keys have different streams. */
import { makeHub } from './hub.js';

const hubs = new Map();

/** @type {any} */ (self).onconnect = /* tsc takes it for a window */
     ({ ports: [port] }) => {
    const watching = new Map(); /* id: the hub that tells of it */
    const watcher = (news) => port.postMessage(news);
    const leave = (id) => {
        watching.get(id)?.leave(watcher, id);
        watching.delete(id);
    };
    port.onmessage = ({ data }) => {
        if (data.gone) return [...watching.keys()].forEach(leave);
        if (data.leave) return leave(data.leave);
        const name = `${data.root} ${data.key}`;
        if (!hubs.has(name)) hubs.set(name, makeHub(data.root, () => data.key));
        watching.set(data.watch, hubs.get(name));
        return hubs.get(name).watch(watcher, data.watch, data.position);
    };
};
