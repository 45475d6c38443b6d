/* The form of a process, made of what the daemon says of it: nothing here knows a parameter by its name. */
import { make } from './dom.js';

/* The parts of a parameter's schema: of "a number or auto" the number, and the words. */
function partsOf(schema) {
    const all = schema.oneOf || [schema];
    return { words: all.flatMap((one) => one.enum || []), free: all.find((one) => !one.enum), pattern: all.find((one) => one.pattern) };
}

const isFile = (schema) => (schema.oneOf || [schema]).some((one) => one.contentEncoding === 'binary');

const unit = (schema) => schema['x-unit'];

function range(schema, free) {
    const words = [];
    if (free && free.minimum !== undefined && free.maximum !== undefined) words.push(`${free.minimum} to ${free.maximum}`);
    if (unit(schema)) words.push(unit(schema));
    if (schema.default !== undefined && String(schema.default) !== '') words.push(`default ${schema.default}`);
    return words.join(', ');
}

function choice(id, schema, words) {
    const select = make('select', { id }, make('option', { value: '' }, schema.default === undefined ? 'not given' : `${schema.default} (default)`));
    words.filter((word) => String(word) !== String(schema.default)).forEach((word) => select.append(make('option', { value: word }, word)));
    return { control: select, read: () => select.value, write: (value) => { select.value = value; } };
}

function several(id, words) {
    const boxes = words.map((word, k) => make('input', { type: 'checkbox', value: word, id: `${id}-${k}` }));
    const control = make('span', { id, className: 'row' }, ...boxes.map((box, k) => make('label', { htmlFor: box.id }, box, words[k])));
    control.setAttribute('role', 'group');
    return { control, group: true, read: () => boxes.filter((box) => box.checked).map((box) => box.value).join(','),
        write: (value) => boxes.forEach((box) => { box.checked = String(value).split(',').includes(box.value); }) };
}

function number(id, schema, { words, free }) {
    const whole = free.type === 'integer', alone = !words.length;
    const input = make('input', { id, type: alone ? 'number' : 'text', placeholder: schema.default ?? '' });
    if (alone) Object.assign(input, { min: free.minimum ?? '', max: free.maximum ?? '', step: whole ? 1 : 'any', inputMode: whole ? 'numeric' : 'decimal' });
    return { control: input, read: () => input.value.trim(), write: (value) => { input.value = value; } };
}

function text(id, schema) {
    const input = make('input', { id, type: 'text', placeholder: String(schema.default ?? '') });
    return { control: input, read: () => input.value.trim(), write: (value) => { input.value = value; } };
}

function controlOf(id, schema) {
    const parts = partsOf(schema), { words, free, pattern } = parts;
    if (schema.type === 'boolean') {
        const box = make('input', { id, type: 'checkbox', checked: Boolean(schema.default) });
        return { control: box, read: () => (box.checked === Boolean(schema.default) ? '' : String(box.checked)), write: (value) => { box.checked = String(value) === 'true'; } };
    }
    if (schema.type === 'array' && schema.items?.enum) return several(id, schema.items.enum);
    if (words.length && !free) return choice(id, schema, words);
    if (free && /integer|number/.test(free.type) && !pattern) return number(id, schema, parts);
    return text(id, schema);
}

function field(name, input) {
    const id = `ask-${name}`, one = controlOf(id, input.schema), help = make('small', { id: `${id}-help` });
    const label = make(one.group ? 'span' : 'label', { className: 'name', id: `${id}-label` }, input.title || name), words = partsOf(input.schema);
    if (one.group) one.control.setAttribute('aria-labelledby', label.id);
    else label.htmlFor = id;
    help.append([input.description, range(input.schema, words.free)].filter(Boolean).join('. '));
    if (words.pattern) help.append(words.words.length ? ` One of ${words.words.join(', ')}, or as said.` : '');
    one.control.setAttribute('aria-describedby', help.id);
    return { ...one, name, row: make('div', { className: 'field' }, label, one.control, help) };
}

/** The form of a process description: {elements: [basic, advanced or null], values() of what was changed, set(values)}. */
export function makeForm(description) {
    const fields = Object.entries(description.inputs).filter(([, input]) => !isFile(input.schema)).map(([name, input]) => ({
        ...field(name, input), basic: input['x-level'] === 'basic', group: input['x-group'] || '' }));
    const basic = fields.filter((one) => one.basic), advanced = fields.filter((one) => !one.basic);
    const rows = (some) => [...new Set(some.map((one) => one.group))].flatMap((group) => [...(group ? [make('h3', {}, group)] : []),
        ...some.filter((one) => one.group === group).map((one) => one.row)]);
    const elements = [...rows(basic)];
    if (advanced.length) elements.push(make('details', { open: !basic.length }, make('summary', {}, `${basic.length ? 'More' : 'All'} parameters (${advanced.length})`), ...rows(advanced)));
    return {
        elements,
        values: () => Object.fromEntries(fields.map((one) => [one.name, one.read()]).filter(([, value]) => value !== '')),
        set: (values) => fields.forEach((one) => one.write(values[one.name] ?? '')),
        /* Shows what the daemon finds wrong with a parameter beside it. */
        blame: (errors) => fields.forEach((one) => {
            const error = errors.find(({ parameter }) => parameter === one.name), place = one.control;
            one.row.classList.toggle('wrong', Boolean(error));
            place.toggleAttribute('aria-invalid', Boolean(error));
            if (error) place.closest('details')?.setAttribute('open', '');
        }),
    };
}
