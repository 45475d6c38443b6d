/* Small helpers about the document and numbers in words. */

/** An element by its id. Of any type: the document says which.
 *  @type {(id: string) => any} */
export const $ = (id) => document.getElementById(id);

/** An element: make('p', {className: 'soft'}, 'text', child ...). */
export function make(tag, properties = {}, ...children) {
    const element = Object.assign(document.createElement(tag), properties);
    element.append(...children);
    return element;
}

export const show = (element, shown) => { element.hidden = !shown; };
export const count = (n) => Number(n).toLocaleString('en');

/** A figure with four digits that tell. */
export function figure(value) {
    if (typeof value !== 'number') return String(value);
    if (Number.isSafeInteger(value)) return count(value);
    if (Math.abs(value) < 1e-4 || Math.abs(value) >= 1e15) return value.toExponential(3).replace(/\.?0*e\+?/, 'e');
    if (value > 0.99 && value < 1) return String(Number(value.toFixed(5))); /* what is left to 1 tells */
    return String(Number(value.toPrecision(4)));
}

/** A figure with three digits, as in headlines. */
export const brief = (value) => figure(Number(value.toPrecision(3)));

export function bytes(n) {
    const units = ['bytes', 'KB', 'MB', 'GB'], k = n < 1000 ? 0 : Math.min(3, Math.floor(Math.log10(n) / 3));
    return `${k ? (n / 1000 ** k).toPrecision(3) : n}\u00a0${units[k]}`;
}

/** How long something may still take: no more digits than such a guess has. */
export function roughly(s) {
    if (s < 60) return `≈ ${Math.max(1, Math.round(s))} s`;
    return s < 3600 ? `≈ ${Math.round(s / 60)} min` : `≈ ${Number((s / 3600).toPrecision(2))} h`;
}

export function seconds(s) {
    if (s < 1) return `${Number(s.toPrecision(2))} s`;
    if (s < 60) return `${s < 10 ? s.toFixed(1) : Math.round(s)} s`;
    return s < 3600 ? `${Math.floor(s / 60)} min ${Math.round(s % 60)} s` : `${Math.floor(s / 3600)} h ${Math.round((s % 3600) / 60)} min`;
}
