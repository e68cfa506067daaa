// SPDX-License-Identifier: Apache-2.0
(() => {
  'use strict';
  const data = JSON.parse(document.getElementById('data').textContent), world = data.world;
  const byId = id => document.getElementById(id);
  if (!world || !byId('world')) return;
  const {objects, areas} = world, plans = [...document.querySelectorAll('.plan')];
  const make = (name, properties, ...children) => {
    const element = Object.assign(document.createElement(name), properties);
    element.append(...children);
    return element;
  };
  const draw = (name, attributes) => {
    const element = document.createElementNS(plans[0].namespaceURI, name);
    Object.entries(attributes).forEach(([key, value]) => element.setAttribute(key, value));
    return element;
  };
  const {plain} = wordSearch;
  const percent = p => `${(100 * p).toFixed(p < 0.1 ? 1 : 0)} %`;
  let shown = [];  // the answers to the last words
  const label = i => data.labels[i].split(',')[0].trim();
  const imageOf = object => {
    const image = document.querySelector(`#image-${object} image`);
    return image && image.getAttribute('href');
  };

  // ---- what words mean: given names, else the objects' labels (estancia ask); `labels`: [[label, probability], …]
  function ask(text, labels) {
    const wanted = plain(text), meant = new Map(labels);
    const answers = objects.map((object, id) => {
      const ranks = object.words.map(([l], i) => meant.has(l) ? i : -1).filter(i => i >= 0);
      const named = object.given !== '' && plain(object.given) === wanted;
      const p = named ? 1 : Math.min(1, ranks.reduce((sum, i) => sum + meant.get(object.words[i][0]) * object.words[i][1] / 1e4, 0));
      return {id, named, p, rank: ranks.length ? ranks[0] + 1 : 0, likely: named || ranks[0] === 0};
    });
    const mean = answers.reduce((sum, a) => sum + a.p, 0) / Math.max(1, answers.length);
    return answers.filter(a => a.likely || (a.rank > 0 && a.rank <= 5 && a.p >= mean))
      .sort((a, b) => b.named - a.named || b.p - a.p || a.rank - b.rank || a.id - b.id);
  }
  // of about equally probable objects the one that costs least to reach (route.tolerance)
  function goalOf(answers) {
    const able = answers.filter(a => a.p > 0 && objects[a.id].pose);
    const enough = able.filter(a => a.p >= 0.9 * able[0].p);
    return enough.reduce((best, a) => !best || objects[a.id].cost < objects[best.id].cost ? a : best, null) || answers[0];
  }

  // ---- the way, drawn into both plans
  function drawWay(object) {
    plans.forEach(plan => {
      const [scale, fromX, fromY, toX, toY] = plan.querySelector('.floor').dataset.fit.split(' ').map(Number);
      const at = ([x, y]) => [toX + scale * (x - fromX), toY - scale * (y - fromY)];
      const group = plan.querySelector('.way');
      group.replaceChildren();
      if (!object) return;
      const line = points => 'M' + points.map(p => at(p).map(v => v.toFixed(1)).join(' ')).join('L');
      if (object.way && object.way.length > 1)
        ['under', 'over'].forEach(kind => group.append(draw('path', {class: kind, d: line(object.way)})));
      if (!object.pose) return;
      const [x, y, yaw] = object.pose, [px, py] = at([x, y]), along = object.distance;
      group.append(
        draw('path', {class: 'look', d: line([[x, y], [x + along * Math.cos(yaw), y + along * Math.sin(yaw)]])}),
        draw('path', {class: 'stand', d: 'M13 0L-8 8L-4 0L-8 -8Z',
          transform: `translate(${px.toFixed(1)} ${py.toFixed(1)}) rotate(${(-yaw * 180 / Math.PI).toFixed(1)})`}));
    });
  }
  function mark(ids, chosen) {
    plans.forEach(plan => plan.classList.toggle('asked', shown.length > 0));
    document.querySelectorAll('.plan [data-object], .item[data-object]').forEach(element => {
      element.classList.toggle('on', ids.includes(+element.dataset.object));
      element.classList.toggle('chosen', +element.dataset.object === chosen);
    });
    plans.forEach(plan => {  // what is chosen lies on top
      const thing = plan.querySelector('.thing.chosen');
      if (thing) thing.parentNode.insertBefore(thing, plan.querySelector('.way'));
    });
  }

  // ---- the panel
  const atFirst = [...byId('found').childNodes];
  function clear() {
    shown = [];
    mark([], -1);
    drawWay(null);
    showAreas([]);
    byId('found').replaceChildren(...atFirst);
    byId('found').hidden = !atFirst.length;
  }
  function describe(id) {
    const object = objects[id], parts = [], image = imageOf(id);
    if (image) parts.push(make('img', {className: 'large', src: image, alt: `What object ${id} looks like`}));
    parts.push(make('h3', {textContent: object.name}),
      make('p', {textContent: [`Object ${id}`, object.probability, object.where].filter(Boolean).join(' · ')}));
    if (object.pose) {
      const [x, y, yaw] = object.pose.map((v, i) => i < 2 ? v.toFixed(2) : (v * 180 / Math.PI).toFixed(0));
      const drive = object.length === undefined ? '' : `From place ${world.from} drive ${object.length.toFixed(1)} m, then stand at `;
      parts.push(make('p', {className: 'go',
        textContent: `${drive || 'Stand at '}(${x}, ${y}) m, yaw ${yaw}°, ${object.distance.toFixed(1)} m from it (${object.frame}).`}));
    }
    const rows = object.words.slice(0, 5).map(([l, p]) => {
      const bar = make('i', {});
      bar.style.width = `${p / 100}%`;
      return make('li', {}, make('span', {className: 'label', textContent: label(l)}),
        make('span', {className: 'bar'}, bar), make('span', {className: 'p', textContent: percent(p / 1e4)}));
    });
    if (rows.length) parts.push(make('ol', {className: 'labels'}, ...rows));
    return parts;
  }
  function items(answers) {
    return make('ul', {className: 'items'}, ...answers.map(a => {
      const link = byId(`object-${a.id}`).cloneNode(true);
      link.removeAttribute('id');
      const note = [a.named ? 'named so' : percent(a.p), objects[a.id].where].filter(Boolean).join(' · ');
      link.lastChild.replaceChildren(make('b', {textContent: objects[a.id].name}), make('small', {textContent: note}));
      return make('li', {}, link);
    }));
  }
  function choose(id, heading) {
    const others = shown.some(a => a.id === id) ? shown : [];
    shown = others;
    const parts = describe(id);
    if (heading) parts.unshift(...heading);
    if (others.length > 1) parts.push(items(others.slice(0, 12)));
    if (others.length > 12) parts.push(make('p', {className: 'say', textContent: `and ${others.length - 12} more on the plan`}));
    byId('found').replaceChildren(...parts);
    byId('found').hidden = false;
    mark(others.length ? others.map(a => a.id) : [id], id);
    drawWay(objects[id]);
  }
  function showAreas(ids) {
    document.querySelectorAll('.plan .area').forEach(link =>
      link.classList.toggle('on', ids.some(id => link.getAttribute('href') === `#area-${id}`)));
  }
  // areas of that name, else those whose name holds the words; people's names first
  function areasOf(text) {
    const wanted = plain(text);
    if (!wanted) return [];
    for (const fits of [name => name === wanted, name => ` ${name} `.includes(` ${wanted} `)])
      for (const key of ['given', 'room']) {
        const found = areas.filter(a => a[key] !== '' && fits(plain(a[key])));
        if (found.length) return found;
      }
    return [];
  }
  function sayAreas(found) {
    const links = found.flatMap((a, i) => [i ? ', ' : '', make('a', {href: `#area-${a.id}`, textContent: a.name})]);
    return make('p', {className: 'say'}, found.length > 1 ? 'are areas: ' : 'is an area: ', ...links, '.');
  }
  const nearestOf = found => found.filter(a => a.way).reduce((best, a) => !best || a.cost < best.cost ? a : best, null);

  document.addEventListener('asked', event => {
    const {text, labels} = event.detail;
    const found = areasOf(text);
    showAreas(found.map(a => a.id));
    const all = ask(text, labels), likely = all.filter(a => a.likely);
    shown = likely.length ? likely : all.slice(0, 5);
    if (found.length || shown.length) event.preventDefault();
    if (!found.length && !labels.length && !shown.length) return clear();
    const heading = [make('h2', {textContent: `“${text}”`})];
    if (found.length) heading.push(sayAreas(found));
    if (!shown.length) {
      mark([], -1);
      const nearest = nearestOf(found);
      drawWay(nearest);
      if (nearest && nearest.length) heading.push(make('p', {className: 'go',
        textContent: `From place ${world.from} drive ${nearest.length.toFixed(1)} m.`}));
      if (!found.length) heading.push(make('p', {className: 'say', textContent: 'No object is it; places that may hold it are below.'}));
      byId('found').replaceChildren(...heading);
      byId('found').hidden = false;
      return;
    }
    heading.push(make('p', {className: 'say', textContent: likely.length
      ? `${likely.length} object${likely.length > 1 ? 's' : ''}`
      : 'No object has it as its best word; the most probable are shown.'}));
    choose(goalOf(shown).id, heading);
  });

  // ---- select by hand; the address keeps what is shown
  document.addEventListener('click', event => {
    const link = event.target.closest && event.target.closest('a[data-object]');
    if (!link) {  // beside everything
      if (event.target.matches && event.target.matches('.plan')) clear();
      return;
    }
    event.preventDefault();
    const id = +link.dataset.object;
    if (!byId('found').contains(link)) shown = [];
    history.replaceState(null, '', `#show=${id}`);
    choose(id);
    hideTip();
    if (link.closest('#areas')) byId('world').scrollIntoView({block: 'start'});
  });

  addEventListener('keydown', event => { if (event.key === 'Escape') clear(); });

  // ---- the larger image beside the pointer
  const tip = byId('tip');
  document.body.append(tip);
  const hideTip = () => { tip.hidden = true; };
  plans.forEach(plan => {
    plan.addEventListener('pointerover', event => {
      const thing = event.pointerType === 'mouse' && event.target.closest('.thing');
      if (!thing) return hideTip();
      const id = +thing.dataset.object, object = objects[id], image = imageOf(id), box = thing.getBoundingClientRect();
      const words = object.words.slice(0, 3).map(([l, p]) => `${label(l)} ${percent(p / 1e4)}`).join(', ');
      tip.replaceChildren(...(image ? [make('img', {src: image, alt: ''})] : []),
        make('b', {textContent: object.name}), make('br'), make('span', {textContent: words || object.where}));
      tip.hidden = false;
      const left = Math.min(box.right + 8, document.documentElement.clientWidth - tip.offsetWidth - 8);
      tip.style.left = `${left + scrollX}px`;
      tip.style.top = `${Math.max(8, Math.min(box.top, innerHeight - tip.offsetHeight - 8)) + scrollY}px`;
    });
    plan.addEventListener('pointerleave', hideTip);
  });

  const names = [...objects, ...areas].map(thing => thing.given || thing.room).filter(Boolean);
  byId('words').append(...[...new Set(names)].sort().map(value => make('option', {value})));
  function follow() {
    const target = /^#(?:show=|object-)(\d+)$/.exec(location.hash);
    if (target && objects[+target[1]]) {
      shown = [];
      choose(+target[1]);
    }
  }
  addEventListener('hashchange', follow);
  follow();
})();
