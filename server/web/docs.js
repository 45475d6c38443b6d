// The contract as people read it: openapi.json, an operation a fold. What it refers to is looked up; schemas are named, and
// shown once at the end.
export {}; // a module: its names are its own

function element(name, text, ...children) {
  const made = document.createElement(name);
  if (text) made.textContent = text;
  made.append(...children.filter(Boolean));
  return made;
}

function typeOf(schema) {
  if (!schema) return '';
  if (schema.$ref) return schema.$ref.split('/').pop();
  const many = schema.oneOf || schema.anyOf || schema.allOf;
  if (many) return many.map(typeOf).join(schema.allOf ? ' and ' : ' or ');
  if (schema.enum) return schema.enum.join(' | ');
  if (schema.type === 'array') return `list of ${typeOf(schema.items)}`;
  const range = 'minimum' in schema || 'maximum' in schema ? ` ${schema.minimum ?? ''} to ${schema.maximum ?? ''}` : '';
  return `${schema.type ?? 'any'}${range}`;
}

function withDefault(schema) {
  return schema && 'default' in schema ? `${typeOf(schema)}, default ${JSON.stringify(schema.default)}` : typeOf(schema);
}

function definitions(rows) {
  const list = element('dl');
  for (const [term, meaning, about] of rows)
    list.append(element('dt', term), element('dd', '', about && element('p', about), meaning && element('p', meaning)));
  return list;
}

function operation(contract, method, path, one) {
  const resolved = (what) =>
    what.$ref ? what.$ref.slice(2).split('/').reduce((at, key) => at[key.replaceAll('~1', '/').replaceAll('~0', '~')], contract) : what;
  const parameters = (one.parameters ?? []).map(resolved);
  const body = one.requestBody && resolved(one.requestBody);
  const answers = Object.entries(one.responses).map(([code, answer]) => [code, resolved(answer)]);
  const fold = element('details', '', element('summary', '', element('code', `${method.toUpperCase()} ${path}`), ` ${one.summary}`),
    element('p', one.description));
  if (parameters.length)
    fold.append(element('h4', 'Parameters'), definitions(parameters.map((p) =>
      [`${p.name} (${p.in}${p.required ? ', required' : ''})`, withDefault(p.schema), p.description])));
  if (body)
    fold.append(element('h4', 'Body'), definitions(Object.entries(body.content).map(([type, c]) => [type, typeOf(c.schema)])));
  fold.append(element('h4', 'Answers'), definitions(answers.map(([code, answer]) =>
    [code, Object.entries(answer.content ?? {}).map(([type, c]) => `${type}: ${typeOf(c.schema)}`).join('; '), answer.description])));
  return fold;
}

// A schema that is made of others has the members of all of them.
function members(schema) {
  return [...Object.entries(schema.properties ?? {}), ...(schema.allOf ?? []).flatMap(members)];
}

const place = document.getElementById('contract');
try {
  const answer = await fetch('openapi.json');
  if (!answer.ok) throw new Error(`openapi.json: ${answer.status}`);
  const contract = await answer.json();
  for (const [path, methods] of Object.entries(contract.paths))
    for (const [method, one] of Object.entries(methods))
      if (one.responses) place.append(operation(contract, method, path, one));
  place.append(element('h3', 'Schemas'));
  for (const [name, schema] of Object.entries(contract.components.schemas)) {
    const fold = element('details', '', element('summary', '', element('code', name), ` ${schema.description ?? ''}`),
      definitions(members(schema).map(([member, of]) => [member, withDefault(of), of.description])));
    if (!members(schema).length) fold.append(element('p', typeOf(schema)));
    place.append(fold);
  }
} catch (error) {
  place.append(element('p', `The API contract cannot be shown: ${error.message}`));
}
