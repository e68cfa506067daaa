// SPDX-License-Identifier: Apache-2.0
// The panel beside the map: answers to a search, and an area, object or place with what people can do to it.
export const make = (name, properties, ...children) => {
  const element = Object.assign(document.createElement(name), properties);
  element.append(...children);
  return element;
};
export const percent = p => `${(100 * p).toFixed(p < 0.1 ? 1 : 0)} %`;

// The server's sentence is what an Error says.
export async function api(path, edit) {
  const request = edit === undefined ? {}
    : {method: 'POST', headers: {'Content-Type': 'application/json'}, body: JSON.stringify(edit)};
  let response;
  try {
    response = await fetch(path, request);
  } catch {
    throw new Error('The robot does not answer: the connection is lost.');
  }
  const answer = await response.json();
  if (!response.ok) throw Object.assign(new Error(answer.error.message), {code: answer.error.code});
  return answer;
}

const sentence = text => text ? text[0].toUpperCase() + text.slice(1) + (/[.!?]$/.test(text) ? '' : '.') : '';
const isNarrow = () => matchMedia('(max-width: 900px)').matches;
const distance = (a, b) => Math.hypot(a[0] - b[0], a[1] - b[1]);

export class Panel {
  // page: {map(), hint(text), isPlaced() → whether it is known where the robot is, changed()}
  constructor(element, plan, page) {
    Object.assign(this, {element, plan, page, shown: null, picking: null, startPlace: null});
  }

  // ---- what is shown
  fill(shown, ...parts) {
    this.shown = shown;
    this.stopPicking();
    const close = make('button', {type: 'button', className: 'close', textContent: '×', title: 'Close (Esc)'});
    close.setAttribute('aria-label', 'Close');
    close.addEventListener('click', () => this.clear());
    this.element.replaceChildren(close, ...parts);
    if (isNarrow()) this.element.scrollIntoView({block: 'nearest'});
  }
  clear() {
    this.stopPicking();
    this.shown = null;
    this.element.replaceChildren();
    this.plan.mark({});
    this.plan.setWay(null);
  }
  say(text, isBad) {
    this.element.querySelector('.say.last')?.remove();
    this.element.append(make('p', {className: `say last${isBad ? ' bad' : ''}`, textContent: sentence(text)}));
  }
  // areas and objects may have got other numbers: what is shown is found again by where it is
  mapChanged() {
    if (this.shown && this.element.contains(document.activeElement) && /INPUT/.test(document.activeElement.tagName)) return;
    const {kind, at, name} = this.shown || {};
    if (kind === 'area') {
      const area = this.areaNow(at);
      if (area && area.name !== name) this.showAgain(() => this.showArea(area.id));
      else if (area) this.plan.mark({areas: [area.id], chosen: ['area', area.id]});
    } else if (kind === 'object') {
      const object = this.objectNow(at);
      if (!object) this.clear();
      else if (object.name !== name) this.showAgain(() => this.showObject(object.id));
      else this.plan.mark({objects: [object.id], chosen: ['object', object.id]});
    }
  }
  // with what was said to people last: that a name was taken brings the name
  showAgain(show) {
    const said = this.element.querySelector('.say.last');
    show();
    if (said) this.element.append(said);
  }
  areaNow(at) {
    const isInside = area => area.outlines.reduce((inside, line) => line.reduce((is, [x, y], i) => {
      const [u, v] = line[(i + 1) % line.length];
      return (y > at[1]) !== (v > at[1]) && at[0] < (u - x) * (at[1] - y) / (v - y) + x ? !is : is;
    }, inside), false);
    return this.page.map().areas.find(isInside);
  }
  objectNow(at) {
    const near = this.page.map().objects.map(o => [distance(o.at, at), o]).sort((a, b) => a[0] - b[0])[0];
    return near && near[0] < 0.5 ? near[1] : null;
  }

  // ---- parts
  chips(things, choose) {
    return make('ul', {className: 'chips'}, ...things.map(thing => {
      const button = make('button', {type: 'button', textContent: thing.name});
      button.addEventListener('click', () => choose(thing));
      return make('li', {}, button);
    }));
  }
  actions(...buttons) {
    return make('div', {className: 'actions'}, ...buttons.map(([text, act, className]) => {
      const button = make('button', {type: 'button', textContent: text, className: className || ''});
      button.addEventListener('click', () => act(button));
      return button;
    }));
  }
  // `edit(name)` → what is sent
  renaming(what, name, hint, edit) {
    const input = make('input', {type: 'text', value: name, maxLength: 60, placeholder: hint, autocomplete: 'off'});
    input.setAttribute('aria-label', `Name of this ${what}`);
    const form = make('form', {className: 'rename'}, input, make('button', {type: 'submit', textContent: 'Save name'}));
    form.addEventListener('submit', async event => {
      event.preventDefault();
      const isDone = await this.send(() => edit(input.value.trim()));
      if (isDone) this.say(input.value.trim() ? `It is called “${input.value.trim()}” from now on` : 'The name is taken away');
    });
    return form;
  }
  async send(edit) {
    this.element.querySelectorAll('button').forEach(button => { button.disabled = true; });
    try {
      const wanted = edit();
      if (!wanted) throw new Error('That is not on the map any more; look again.');
      await api('/api/edits', wanted);
      document.activeElement.blur();
      this.page.changed();
      return true;
    } catch (problem) {
      this.say(problem.message, true);
      return false;
    } finally {
      this.element.querySelectorAll('button').forEach(button => { button.disabled = false; });
    }
  }
  image(path, alt) {
    const image = make('img', {className: 'large', src: path, alt});
    image.onerror = () => image.remove();
    return image;
  }

  // ---- ways
  // Without "from" they start where the robot is: the server knows which places the map has by now.
  start() {
    if (this.startPlace === null && this.page.isPlaced()) return {};
    const from = this.startPlace ?? this.page.map().places[0]?.node;
    return from === undefined ? null : {from};
  }
  async way(to, isQuiet) {
    const from = this.start(), asked = this.shown;
    if (from === null) return;
    try {
      const route = await api(`/api/route?${new URLSearchParams({to, ...from})}`);
      if (this.shown !== asked) return;
      this.plan.setWay(route);
      const through = (route.areas || []).filter(Boolean).map(a => a.name);
      const length = route.unit === 'm' ? `${route.cost.toFixed(1)} m` : `${route.cost} transitions`;
      const stand = route.pose ? ` Stand ${route.pose.distance.toFixed(1)} m from it, at (${route.pose.x.toFixed(1)}, ${route.pose.y.toFixed(1)}) m.` : '';
      this.element.querySelector('.go')?.remove();
      const way = route.cost < 0.05 ? `Place ${route.from} is there already.`
        : `From place ${route.from} drive ${length}${through.length > 1 ? `: ${through.join(' → ')}` : ''}.`;
      this.element.querySelector('.facts-line').after(make('p', {className: 'go', textContent: way + stand}));
    } catch (problem) {
      if (!isQuiet) this.say(problem.message, true);
    }
  }

  // ---- search
  async search(words) {
    let found;
    try {
      found = await api(`/api/ask?${new URLSearchParams({words, max: 12})}`);
    } catch (problem) {
      this.fill({kind: 'search'}, make('h2', {textContent: `“${words}”`}));
      this.say(problem.message, true);
      return;
    }
    const {areas, objects, places} = found;
    this.answers = {areas: areas.map(a => a.id), objects: objects.map(o => o.id), places: objects.length || areas.length ? [] : places.map(p => p.node)};
    const parts = [make('h2', {textContent: `“${words}”`}), make('p', {className: 'facts-line', textContent: this.understood(found)})];
    const isLikely = o => o.named || o.recognized || o.by_shape || o.rank === 1;
    const item = o => this.item(o.id, o.name, this.reason(o), () => this.showObject(o.id), `/api/objects/${o.id}.jpg`);
    const likely = objects.filter(isLikely), others = objects.filter(o => !isLikely(o));
    const items = [...areas.map(a => this.item(a.id, a.name, `Area · ${a.size.toFixed(1)} m²`, () => this.showArea(a.id), null)), ...likely.map(item)];
    const more = [...others.map(item), ...places.map(p => this.item(p.node, `Place ${p.node}${p.area ? `, ${p.area.name}` : ''}`,
      `${percent(p.probability)}${p.label ? ` · “${p.label.split(',')[0]}” is its word no. ${p.rank}` : ''}`, () => this.showPlace(p.node), `/api/places/${p.node}.jpg`))];
    if (items.length) parts.push(make('ul', {className: 'items'}, ...items));
    if (items.length && more.length) {
      parts.push(make('details', {}, make('summary', {textContent: `Less likely (${more.length})`}), make('ul', {className: 'items'}, ...more)));
    } else if (more.length) {
      parts.push(make('p', {className: 'say', textContent: 'Nothing is most probably that. The most probable:'}), make('ul', {className: 'items'}, ...more));
    }
    const isFound = items.length + more.length > 0;
    if (likely.length) this.answers.objects = likely.map(o => o.id);
    this.fill({kind: 'search', words}, ...parts);
    this.plan.setWay(null);
    this.plan.mark(this.answers);
    if (!isFound && found.near_spellings.length)
      this.element.append(make('h3', {textContent: 'Did you mean'}), this.chips(found.near_spellings.map(name => ({name})), ({name}) => {
        document.getElementById('word').value = name;
        this.search(name);
      }));
    if (isFound) this.way(words, true);
  }
  understood(found) {
    const kinds = found.matches.filter(m => m.reason).slice(0, 4).map(m => `${m.label.split(',')[0]} (${m.reason})`);
    const parts = [];
    if (found.corrected) parts.push(`read as “${found.corrected}”`);
    if (kinds.length) parts.push(`taken for ${kinds.join(', ')}`);
    if (!found.areas.length && !found.objects.length && !found.places.length) parts.push('nothing on the map means that');
    return sentence(parts.join('; '));
  }
  reason(object) {
    const why = object.named ? 'named so' : object.recognized ? 'recognized as it'
      : object.by_shape && object.rank !== 1 ? 'by its shape' : `word no. ${object.rank}`;
    return [percent(object.probability), why, object.area && object.area.name].filter(Boolean).join(' · ');
  }
  item(id, name, note, choose, image) {
    const swatch = make('span', {className: 'swatch', textContent: image ? '' : `${id}`}), shown = image ? make('img', {src: image, alt: '', loading: 'lazy'}) : swatch;
    if (image) shown.onerror = () => { swatch.textContent = `${id}`; shown.replaceWith(swatch); };
    const button = make('button', {type: 'button', className: 'item'}, shown, make('span', {}, make('b', {textContent: name}), make('small', {textContent: note})));
    button.addEventListener('click', choose);
    return make('li', {}, button);
  }
  backToAnswers() {
    const shown = this.shown;
    const words = shown && shown.words;
    return words ? [['← All answers', () => this.search(words)]] : [];
  }

  // ---- what has changed since the last drive began
  async showChanges() {
    this.fill({kind: 'changes'}, make('h2', {textContent: 'What has changed'}));
    const asked = this.shown;
    let found;
    this.say('Looking');
    try {
      found = await api('/api/changes');
    } catch (problem) {
      if (this.shown === asked) this.say(problem.message, true);
      return;
    }
    if (this.shown !== asked) return;
    const kinds = {moved: 'Moved', gone: 'Gone', new: 'New'};
    const inArea = area => area && area.name ? ` in ${area.name}` : '';
    const point = at => `(${at[0].toFixed(1)}, ${at[1].toFixed(1)}) m`;
    const note = change => [change.from_at && `from ${point(change.from_at)}${inArea(change.from_area)}`,
      change.to_at && `to ${point(change.to_at)}${inArea(change.to_area)}`].filter(Boolean).join(' ');
    const show = change => {
      const object = this.objectNow(change.to_at || change.from_at);
      if (object) this.plan.mark({objects: [object.id], chosen: ['object', object.id]});
    };
    const items = found.objects.map(change => {
      const thing = change.name === null ? 'something' : `${change.whole ? '' : 'part of '}${change.name}`;
      const shown = change.object_now ?? change.object_before;
      return this.item('', `${kinds[change.kind]}: ${thing}`, note(change), () => show(change), shown === null ? null : `/api/objects/${shown}.jpg`);
    });
    for (const place of found.places)
      items.push(this.item(place.node, `Place ${place.node} looks different`, place.words.slice(0, 3).map(w =>
        `${w.label.split(',')[0]} ${percent(w.before)} → ${percent(w.now)}`).join(', '), () => this.showPlace(place.node), null));
    this.fill({kind: 'changes'}, make('h2', {textContent: 'What has changed'}),
      make('p', {className: 'facts-line', textContent: `Since drive ${found.since} began`}),
      items.length ? make('ul', {className: 'items'}, ...items)
        : make('p', {className: 'say', textContent: 'Nothing that was looked at again has changed.'}));
    this.plan.setWay(null);
    this.plan.mark({});
  }

  // ---- an area
  showArea(id) {
    const area = this.page.map().areas.find(a => a.id === id), back = this.backToAnswers(), words = this.shown?.words;
    if (!area) return;
    const objects = this.page.map().objects.filter(o => o.area && o.area.id === id);
    const room = area.predicted_room && area.predicted_room !== area.name ? ` · looks like: ${area.predicted_room} (${percent(area.room_probability)})` : '';
    const parts = [make('h2', {textContent: area.name}),
      make('p', {className: 'facts-line', textContent: `Area ${area.id} · ${area.size.toFixed(1)} m² · ${area.frames} images${room}`}),
      this.renaming('area', area.given_name || '', area.name, name => {
        const now = this.areaNow(area.center);
        return now && {type: 'name_area', area: now.id, name};
      }),
      this.actions(...back, ['Way there', () => this.wayToArea(id)], ['Merge with …', () => this.merge(area)], ['Split', () => this.split(area)])];
    if (objects.length) parts.push(make('h3', {textContent: 'Objects in it'}), this.chips(objects, o => this.showObject(o.id)));
    this.fill({kind: 'area', at: area.center, name: area.name, words}, ...parts);
    this.plan.setWay(null);
    this.plan.mark({areas: [id], chosen: ['area', id]});
  }
  wayToArea(id) {
    const inIt = this.page.map().places.filter(p => p.area && p.area.id === id).sort((a, b) => b.frames - a.frames)[0];
    if (inIt) this.way(`${inIt.node}`);
    else this.say('The robot never drove into this area: it only saw it', true);
  }
  merge(area) {
    this.startPicking({kind: 'merge', at: area.center}, `Select the area that is one with “${area.name}”`);
    const others = this.page.map().areas.filter(a => a.id !== area.id);
    this.choices = make('div', {}, make('h3', {textContent: 'Which is one with it?'}), this.chips(others, other => this.clickedArea(other.id)));
    this.element.append(this.choices);
  }
  split(area) {
    this.startPicking({kind: 'split', ends: []}, `Select two points: “${area.name}” is cut halfway, along the line between them`);
    const labels = ['From x', 'y', 'To x', 'y'];
    this.inputs = labels.map(() => make('input', {type: 'number', step: 'any', required: true}));
    const form = make('form', {}, make('div', {className: 'ends'}, ...labels.map((text, i) => make('label', {textContent: `${text} [m]`}, this.inputs[i]))),
      make('div', {className: 'actions'}, make('button', {type: 'submit', textContent: 'Split here'})));
    const ends = () => [[+this.inputs[0].value, +this.inputs[1].value], [+this.inputs[2].value, +this.inputs[3].value]];
    form.addEventListener('input', () => this.plan.setCut(ends()));
    form.addEventListener('submit', async event => {
      event.preventDefault();
      const [from, to] = ends();
      if (await this.send(() => ({type: 'split_area', from, to}))) this.clear();
    });
    this.choices = form;
    this.element.append(form);
  }

  // ---- picking on the map
  startPicking(picking, hint) {
    this.stopPicking();
    this.picking = picking;
    this.page.hint(hint);
    this.plan.pick(true);
    if (isNarrow()) this.plan.svg.scrollIntoView({block: 'center'});
  }
  stopPicking() {
    this.choices?.remove();
    this.choices = this.picking = null;
    this.page.hint('');
    this.plan.pick(false);
    this.plan.setCut(null);
  }
  async clickedArea(id, point) {
    if (!this.picking) return this.showArea(id);
    if (this.picking.kind === 'split') return this.clickedFloor(point);
    const {at} = this.picking, other = this.page.map().areas.find(a => a.id === id);
    if (!other || (await this.send(() => {
      const one = this.areaNow(at), two = this.areaNow(other.center);
      return one && two && {type: 'merge_areas', area: one.id, other: two.id};
    }))) this.clear();
  }
  clickedFloor(point) {
    if (!this.picking) return this.clear();
    if (this.picking.kind !== 'split' || !point) return;
    const {ends} = this.picking;
    if (ends.length === 2) ends.length = 0;
    ends.push(point);
    ends.forEach(([x, y], i) => { this.inputs[2 * i].value = x.toFixed(2); this.inputs[2 * i + 1].value = y.toFixed(2); });
    this.plan.setCut(ends);
    if (ends.length === 2) this.choices.querySelector('button').focus();
  }

  // ---- an object
  showObject(id) {
    const object = this.page.map().objects.find(o => o.id === id), back = this.backToAnswers(), words = this.shown?.words;
    if (!object) return;
    const facts = [`Object ${id}`, object.given_name ? 'named by people' : object.known ? `recognized, ${percent(object.known.confidence)}` : object.probability ? percent(object.probability) : '',
      object.where, `seen in ${object.views} images`].filter(Boolean).join(' · ');
    const edit = rest => name => {
      const now = this.objectNow(object.at);
      return now && {...rest, object: now.id, ...(rest.type === 'name_object' ? {name} : {})};
    };
    this.fill({kind: 'object', at: object.at, name: object.name, words},
      make('h2', {textContent: object.name}), make('p', {className: 'facts-line', textContent: facts}),
      this.image(`/api/objects/${id}.jpg`, `What object ${id} looks like`),
      this.renaming('object', object.given_name || '', object.name, edit({type: 'name_object'})),
      this.actions(...back, ['Way there', () => this.way(`${object.node}`)], ['Delete', button => this.remove(button, edit({type: 'delete_object'})), 'danger']));
    this.plan.setWay(null);
    this.plan.mark({objects: [id], chosen: ['object', id]});
  }
  // asks once more
  async remove(button, edit) {
    if (button.dataset.sure) {
      if (await this.send(() => edit())) this.clear();
      return;
    }
    button.dataset.sure = 'yes';
    button.textContent = 'Really delete?';
    setTimeout(() => { delete button.dataset.sure; button.textContent = 'Delete'; }, 4000);
  }

  // ---- a place
  async showPlace(node) {
    const back = this.backToAnswers(), words = this.shown?.words;
    let place;
    try {
      place = await api(`/api/places/${node}`);
    } catch (problem) {
      this.fill({kind: 'place'}, make('h2', {textContent: `Place ${node}`}));
      return this.say(problem.message, true);
    }
    const facts = [place.name, place.area && place.area.name !== place.name && `in ${place.area.name}`, `${place.frames} images`].filter(Boolean).join(' · ');
    const most = Math.max(...place.words.map(w => w.probability), 1e-9);
    const bars = place.words.slice(0, 6).map(({label, probability}) => {
      const bar = make('i', {});
      bar.style.width = `${100 * probability / most}%`;
      return make('li', {}, make('span', {className: 'label', textContent: label.split(',')[0], title: label}), make('span', {className: 'bar'}, bar),
        make('span', {className: 'p', textContent: percent(probability)}));
    });
    const parts = [make('h2', {textContent: `Place ${node}`}), make('p', {className: 'facts-line', textContent: facts}), this.image(`/api/places/${node}.jpg`, `What place ${node} looks like`),
      this.actions(...back, ['Way there', () => this.way(`${node}`)], ['Start ways here', () => {
        this.startPlace = node;
        this.say(`Ways start at place ${node} until the page is opened again`);
      }]),
      make('h3', {textContent: 'Seen there'}), make('ol', {className: 'labels'}, ...bars)];
    if (place.objects.length) parts.push(make('h3', {textContent: 'Objects'}), this.chips(place.objects, o => this.showObject(o.id)));
    if (place.neighbors.length) parts.push(make('h3', {textContent: 'Ways lead to'}), this.chips(place.neighbors.map(n => ({...n, name: n.name ? `${n.node} ${n.name}` : `${n.node}`})), n => this.showPlace(n.node)));
    this.fill({kind: 'place', node, words}, ...parts);
    this.plan.setWay(null);
    this.plan.mark({places: [node], chosen: ['place', node]});
  }
}
