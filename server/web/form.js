/* The form of a process, made of what the daemon says of it: nothing here knows a parameter by its name. */
import { figure, make, show } from './dom.js';

/* The parts of a parameter's schema: of "a number or auto" the number, and the words. */
function partsOf(schema) {
    const all = schema.oneOf || [schema];
    return { words: all.flatMap((one) => one.enum || []), free: all.find((one) => !one.enum), pattern: all.find((one) => one.pattern) };
}

const isFile = (schema) => (schema.oneOf || [schema]).some((one) => one.contentEncoding === 'binary');

const unit = (schema) => schema['x-unit'];

/* Bounds as wide as this are no bounds that a person would meet. */
const [TINY, HUGE] = [1e-30, 1e30];

/* "1 to 90 degrees. Default 15." */
function range(schema, free) {
    const words = [];
    if (free && free.minimum > 0 && free.minimum <= TINY && free.maximum >= HUGE)
        words.push(unit(schema) ? `In the ${unit(schema)}, above 0` : 'Above 0');
    else if (free && free.minimum !== undefined && free.maximum !== undefined)
        words.push([`${figure(free.minimum)} to ${figure(free.maximum)}`, unit(schema)].filter(Boolean).join(' '));
    else if (unit(schema)) words.push(`In ${unit(schema)}`);
    if (schema.default !== undefined && String(schema.default) !== '') words.push(`Default ${schema.default}`);
    return words.map((one) => `${one}.`).join(' ');
}

function choice(id, schema, words) {
    const select = make('select', { id }, make('option', { value: '' }, schema.default === undefined ? 'not set' : `${schema.default} (default)`));
    words.filter((word) => String(word) !== String(schema.default)).forEach((word) => select.append(make('option', { value: word }, word)));
    return { control: select, read: () => select.value, write: (value) => { select.value = String(value) === String(schema.default) ? '' : value; } };
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

/* Words that are no more than examples are offered while somebody types. */
function text(id, schema, words) {
    const input = make('input', { id, type: 'text', placeholder: String(schema.default ?? '') });
    const offered = words.length ? [make('datalist', { id: `${id}-words` }, ...words.map((word) => make('option', { value: word })))] : [];
    if (words.length) input.setAttribute('list', `${id}-words`);
    return { control: input, besides: offered, read: () => input.value.trim(), write: (value) => { input.value = value; } };
}

/* A cloud beside the one that the page shows. */
function file(id) {
    const input = make('input', { id, type: 'file' });
    return { control: input, file: () => input.files[0], read: () => '', write: () => { input.value = ''; } };
}

/** The control of a schema, and how its value is read and written.
 *  @return {{control: any, read: () => string, write: (value: any) => void, file?: () => File, group?: boolean, besides?: any[]}} */
function controlOf(id, schema) {
    if (isFile(schema)) return file(id);
    const parts = partsOf(schema), { words, free, pattern } = parts;
    if (schema.type === 'boolean') {
        const usual = Boolean(schema.default), box = make('input', { id, type: 'checkbox', checked: usual });
        return { control: box, read: () => (box.checked === usual ? '' : String(box.checked)),
            write: (value) => { box.checked = value === '' ? usual : String(value) === 'true'; } };
    }
    if (schema.type === 'array' && schema.items?.enum) return several(id, schema.items.enum);
    if (words.length && !free) return choice(id, schema, words);
    if (free && /integer|number/.test(free.type) && !pattern) return number(id, schema, parts);
    return text(id, schema, words);
}

/* What a parameter means is told when it is asked for. */
function aboutButton(help, title) {
    const button = make('button', { type: 'button', className: 'about', title: `About ${title}` }, '?');
    button.setAttribute('aria-label', `About ${title}`);
    button.setAttribute('aria-controls', help.id);
    button.setAttribute('aria-expanded', 'false');
    button.addEventListener('click', () => {
        show(help, help.hidden);
        button.setAttribute('aria-expanded', String(!help.hidden));
    });
    return button;
}

function field(name, input) {
    const id = `ask-${name}`, one = controlOf(id, input.schema), wrong = make('small', { id: `${id}-wrong`, className: 'blame' });
    const help = make('small', { id: `${id}-help`, hidden: true }), title = input.title || name;
    const of = unit(input.schema), label = make(one.group ? 'span' : 'label', { className: 'name', id: `${id}-label` }, title,
        make('small', {}, of && of !== title.toLowerCase() ? `, ${of}` : '')), words = partsOf(input.schema);
    if (one.group) one.control.setAttribute('aria-labelledby', label.id);
    else label.htmlFor = id;
    help.append([input.description && `${input.description}.`, range(input.schema, words.free)].filter(Boolean).join(' '));
    one.control.setAttribute('aria-describedby', `${wrong.id} ${help.id}`);
    return { ...one, name, wrong, usual: String(input.schema.default ?? ''), when: input['x-when'] || {},
        row: make('div', { className: 'field' }, label, one.control, aboutButton(help, title), wrong, help, ...(one.besides || [])) };
}

/* Whether a field counts: another one that it hangs on has one of these words, of which attribute:NAME is any that begins so. */
function counts({ when }, fields) {
    return Object.entries(when).every(([name, words]) => {
        const other = fields.find((one) => one.name === name), value = other.read() || other.usual;
        return words.some((word) => word === value || (word.endsWith(':NAME') && value.startsWith(word.slice(0, -4))));
    });
}

/* Fields under the titles of their groups: {rows, elements}. */
function grouped(fields) {
    return [...new Set(fields.map((one) => one.group))].map((group) => {
        const rows = fields.filter((one) => one.group === group).map((one) => one.row);
        return { rows, element: make('div', {}, ...(group ? [make('h3', {}, group)] : []), ...rows) };
    });
}

/* Of the parameters of this group one at most is given: a choice shows its field. */
const ONE_OF = 'How many points';

/* The choice between fields: {element, chosen() the name of one, choose(name)}. process: tells apart the radio buttons of forms. */
function makeWays(fields, process) {
    const usual = fields.find((one) => one.usual) || fields[0], radios = fields.map((one) => make('input', {
        type: 'radio', name: `way-${process}`, value: one.name, id: `way-${process}-${one.name}`, checked: one === usual }));
    const element = make('div', { className: 'row' }, ...radios.map((one) => make('label', { htmlFor: one.id }, one, one.value[0].toUpperCase() + one.value.slice(1))));
    element.setAttribute('role', 'radiogroup');
    element.setAttribute('aria-label', ONE_OF);
    return { element, usual: usual?.name, chosen: () => radios.find((one) => one.checked)?.value,
        choose: (name) => radios.forEach((one) => { one.checked = one.value === name; }) };
}

const folded = (groups) => make('details', {}, make('summary'), ...groups.map((one) => one.element));

/** The form of a process description, but for its main input: {elements: [what is asked for first, folded options ...], values() of
 *  what was changed and counts, files() that were chosen, by name, set(values), blame(errors)}. */
export function makeForm(description) {
    const main = Object.entries(description.inputs).find(([, input]) => isFile(input.schema));
    const fields = Object.entries(description.inputs).filter(([name]) => name !== main?.[0]).map(([name, input]) => ({
        ...field(name, input), basic: input['x-level'] === 'basic' || isFile(input.schema), group: input['x-group'] || '' }));
    const [first, ways] = [(one) => (ways.element.childElementCount ? one.group === ONE_OF : one.basic),
        makeWays(fields.filter((one) => one.group === ONE_OF), description.id)];
    const groups = [first, (one) => one.basic && !first(one), (one) => !one.basic && !first(one)].map((which) => grouped(fields.filter(which)));
    const folds = groups.slice(1).map((all, k) => ({ all, title: ['Options', 'Advanced options'][k], element: folded(all) }));
    groups[0].find(({ rows }) => rows.includes(fields.find((one) => one.group === ONE_OF)?.row))?.element.querySelector('h3').after(ways.element);
    const refresh = () => {
        fields.forEach((one) => {
            show(one.row, counts(one, fields) && (one.group !== ONE_OF || one.name === ways.chosen()));
            one.row.querySelectorAll('input, select').forEach((control) => { control.disabled = one.row.hidden; }); /* nor is it checked */
        });
        groups.flat().forEach(({ rows, element }) => show(element, rows.some((row) => !row.hidden)));
        folds.forEach(({ all, title, element }) => {
            const shown = fields.filter(({ row }) => !row.hidden && all.some(({ rows }) => rows.includes(row))), set = shown.filter((one) => one.read() !== '');
            element.firstChild.textContent = `${title} (${shown.length}${set.length ? `, ${set.length} set` : ''})`;
        });
    };
    const elements = [...groups[0].map((one) => one.element), ...folds.filter(({ all }) => all.length).map((one) => one.element)];
    elements.forEach((one) => one.addEventListener('input', refresh));
    refresh();
    return {
        elements, refresh,
        field: (name) => fields.find((one) => one.name === name),
        values: () => Object.fromEntries(fields.filter((one) => !one.row.hidden).map((one) => [one.name, one.read()])
            .filter(([, value]) => value !== '')),
        files: () => Object.fromEntries(fields.map((one) => [one.name, one.file?.()]).filter(([, chosen]) => chosen)),
        set(values) {
            fields.forEach((one) => one.write(values[one.name] ?? ''));
            ways.choose([...fields].reverse().find((one) => one.group === ONE_OF && values[one.name] !== undefined)?.name || ways.usual);
            refresh();
        },
        /* Shows what the daemon finds wrong with a parameter beside it. */
        blame(errors) {
            fields.forEach((one) => {
                const error = errors.find(({ parameter }) => parameter === one.name);
                one.row.classList.toggle('wrong', Boolean(error));
                one.control.setAttribute('aria-invalid', String(Boolean(error)));
                one.wrong.textContent = error?.detail || '';
                if (error && one.group === ONE_OF) ways.choose(one.name);
                if (error) one.control.closest('details')?.setAttribute('open', '');
            });
            if (errors.length) refresh();
            fields.find((one) => one.row.classList.contains('wrong'))?.control.focus();
        },
    };
}
