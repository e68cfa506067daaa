// SPDX-License-Identifier: Apache-2.0
(() => {
  'use strict';
  const data = JSON.parse(document.getElementById('data').textContent);
  const byId = id => document.getElementById(id);
  if (!byId('map')) return;

  // ---- the index turned round: label → [[node, p], …]
  const holders = data.labels.map(() => []);
  data.index.forEach((row, node) => {
    let label = 0;
    for (let i = 0; i < row.length; i += 2) holders[label += row[i]].push([node, row[i + 1] / 1e4]);
  });
  holders.forEach(list => list.sort((a, b) => b[1] - a[1]));
  const synonyms = data.labels.map(line => line.toLowerCase().split(',').map(word => word.trim()));
  const shortName = label => data.labels[label].split(',')[0].trim();

  const make = (name, properties, ...children) => {
    const element = Object.assign(document.createElement(name), properties);
    element.append(...children);
    return element;
  };
  const significant = p => p === 0 ? '0' : p.toFixed(p >= 0.1 ? 3 : 4).replace(/\.?0+$/, '');

  // ---- colors
  const mixed = t => {
    const place = Math.min(Math.max(t, 0), 1) * (data.colors.length - 1);
    const below = Math.min(Math.floor(place), data.colors.length - 2);
    return data.colors[below].map((c, i) => Math.round(c + (place - below) * (data.colors[below + 1][i] - c)));
  };
  const ink = rgb => {
    const linear = rgb.map(c => (c /= 255) <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4);
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2] > 0.179 ? '#000' : '#fff';
  };
  const fromHex = hex => [1, 3, 5].map(i => parseInt(hex.slice(i, i + 2), 16));
  const drawn = [...document.querySelectorAll('.map .node')];
  const dye = (element, [rgb, shape]) => {
    const path = element.querySelector('path');
    path.setAttribute('fill', `rgb(${rgb})`);
    path.setAttribute('d', data.shapes[shape]);
    const text = element.querySelector('text');
    if (text) text.setAttribute('fill', ink(rgb));
  };
  const paint = styleOf => drawn.forEach(element =>
    dye(element, styleOf(data.nodes[element.dataset.node], +element.dataset.node)));
  // the badges of cards, and of the card in the panel, tell the room or the zone: `at` is where a node has its color
  const paintBadges = at => document.querySelectorAll('.card[data-node]').forEach(card => {
    const node = data.nodes[card.dataset.node];
    dye(card.querySelector('.badge'), [fromHex(node[at]), node[at + 1]]);
  });
  const legend = shown => ['heat', 'rooms', 'zones'].forEach(name => {
    if (byId(`legend-${name}`)) byId(`legend-${name}`).hidden = name !== shown;
    if (byId(`by-${name}`)) byId(`by-${name}`).setAttribute('aria-pressed', String(name === shown));
  });

  // ---- one label: heat map and ranking
  const panel = name => {
    byId('ranking').hidden = name !== 'ranking';
    byId('detail').hidden = name !== 'detail';
  };
  const showLabel = label => showLabels([[label, 1]], shortName(label));
  // `labels`: [[label, how probably it is meant], …]
  function showLabels(labels, words) {
    const sums = new Map();
    labels.forEach(([label, weight]) => holders[label].forEach(([node, value]) =>
      sums.set(node, Math.min(1, (sums.get(node) || 0) + weight * value))));
    const held = [...sums].sort((a, b) => b[1] - a[1] || a[0] - b[0]), largest = held.length ? held[0][1] : 0;
    const p = new Float32Array(data.nodes.length);
    held.forEach(([node, value]) => { p[node] = value; });
    paint((node, i) => [mixed(largest ? p[i] / largest : 0), node[3]]);
    paintBadges(2);
    legend('heat');
    document.querySelectorAll('.heat-ticks span').forEach((tick, i) => {
      tick.textContent = significant(largest * i / 2);
    });
    const places = held.slice(0, 10).map(([node, value]) => {
      const bar = make('i', {});
      bar.style.width = `${100 * value / largest}%`;
      bar.style.background = `rgb(${mixed(value / largest)})`;
      const link = make('a', {href: `#node-${data.nodes[node][0]}`},
        make('b', {textContent: data.nodes[node][0]}),
        make('span', {className: 'label', textContent: data.nodes[node][1]}),
        make('span', {className: 'bar'}, bar),
        make('span', {className: 'p', textContent: significant(value)}));
      return make('li', {}, link);
    });
    byId('ranking').replaceChildren(
      make('h2', {textContent: `Where is “${words}”?`}),
      places.length ? make('ol', {className: 'places'}, ...places)
        : make('p', {textContent: `No node gives it ${data.least} or more.`}));
    panel('ranking');
    byId('word').value = words;
  }

  // ---- search: the whole synonym, then its beginning, then anywhere; else near spellings
  function distance(a, b) {
    let row = Array.from({length: b.length + 1}, (_, i) => i);
    for (let i = 1; i <= a.length; ++i) {
      const next = [i];
      for (let j = 1; j <= b.length; ++j)
        next[j] = Math.min(row[j] + 1, next[j - 1] + 1, row[j - 1] + (a[i - 1] !== b[j - 1]));
      row = next;
    }
    return row[b.length];
  }
  function matches(text) {
    const wanted = text.trim().toLowerCase();
    if (!wanted) return [];
    const rank = word => word === wanted ? 0 : word.startsWith(wanted) ? 1 : word.includes(wanted) ? 2 : 9;
    const likelihood = label => holders[label].length ? holders[label][0][1] : 0;
    return synonyms.map((words, label) => [Math.min(...words.map(rank)), label])
      .filter(([r]) => r < 9)
      .sort((a, b) => a[0] - b[0] || likelihood(b[1]) - likelihood(a[1]) || a[1] - b[1])
      .map(([, label]) => label);
  }
  const near = text => synonyms
    .map((words, label) => [Math.min(...words.map(w => distance(w.slice(0, 40), text.trim().toLowerCase().slice(0, 40)))), label])
    .sort((a, b) => a[0] - b[0] || a[1] - b[1]).filter(([d]) => d <= 3).map(([, label]) => label);
  const has = (label, words) => synonyms[label].some(name => ` ${wordSearch.plain(name)} `.includes(` ${words} `));
  // labels named so, else those that the words mean and those whose names hold them, else the first that was found
  function meaningOf(text, found) {
    const words = wordSearch.plain(text), held = found.filter(label => has(label, words));
    const named = synonyms.flatMap((names, label) =>
      words && names.some(name => wordSearch.plain(name) === words) ? [label] : []);
    if (named.length) return {labels: named.map(label => [label, 1])};
    const meaning = wordSearch.understand(text), labels = new Map(meaning.labels);
    if (!labels.size)
      return {labels: (held.length ? held : found.slice(0, 1)).map(label => [label, 1]), known: meaning.known};
    held.forEach(label => labels.set(label, Math.max(labels.get(label) || 0, wordSearch.least)));
    return {labels: [...labels].sort((a, b) => b[1] - a[1]), corrected: meaning.corrected, understood: true};
  }
  const tell = (text, labels) =>  // the floor plan listens
    !document.dispatchEvent(new CustomEvent('asked', {detail: {text, labels}, cancelable: true}));
  const chip = label => make('button', {
    type: 'button', textContent: shortName(label), title: data.labels[label],
    onclick: () => { location.hash = 'label=' + encodeURIComponent(data.labels[label]); }
  });
  function search(text) {
    const found = matches(text), meaning = meaningOf(text, found), {labels} = meaning;
    const hint = (...parts) => byId('hint').replaceChildren(...parts);
    const isNamed = tell(text, labels) && !labels.length;
    if (isNamed) return hint();
    if (!labels.length) {
      const offered = meaning.known ? [] : near(text).slice(0, 5);
      return hint(meaning.known ? `No label of this map means “${text}”.`
        : `No label holds “${text}”.` + (offered.length ? ' Did you mean ' : ''), ...offered.map(chip));
    }
    const others = shown => found.filter(label => !shown.includes(label));
    const also = rest => rest.length ? ['Also: ', ...rest.map(chip)] : [];
    if (!meaning.understood) {
      const shown = found.length ? found[0] : labels[0][0];
      hint(...also(others([shown]).slice(0, 6)));
      return showLabel(shown);
    }
    const meant = labels.map(([label]) => label);  // models of one page may share names
    const first = meant.filter((label, i) => meant.findIndex(l => shortName(l) === shortName(label)) === i).slice(0, 8);
    hint(meaning.corrected ? `Read as “${meaning.corrected}” → ` : `“${text.trim()}” → `, ...first.map(chip),
      ...also(others(meant).slice(0, 4)));
    showLabels(labels, text.trim());
  }

  // ---- one node
  function select(id) {
    const node = data.nodes.findIndex(entry => entry[0] === id), card = byId(`node-${id}`);
    if (node < 0 || !card) return;
    drawn.forEach(element => element.classList.toggle('selected', +element.dataset.node === node));
    document.querySelectorAll('.map .link').forEach(link =>
      link.classList.toggle('near', link.dataset.ends.split(' ').includes(String(node))));
    const copy = card.cloneNode(true);
    copy.removeAttribute('id');
    copy.className = 'card';
    const back = make('button', {type: 'button', id: 'back', textContent: '← Back to the ranking'});
    back.onclick = () => panel('ranking');
    byId('detail').replaceChildren(back, copy);
    panel('detail');
    if (matchMedia('(max-width: 1020px)').matches) byId('detail').scrollIntoView({block: 'start'});
  }

  // ---- links to nodes inside the map and its panels open the panel; the address keeps what is shown
  document.addEventListener('click', event => {
    const link = event.target.closest && event.target.closest('#map a');
    const target = link && /^#node-(-?\d+)$/.exec(link.getAttribute('href'));
    if (!target) return;
    event.preventDefault();
    history.replaceState(null, '', '#select=' + target[1]);
    select(+target[1]);
  });
  byId('search').addEventListener('submit', event => {
    event.preventDefault();
    const text = byId('word').value;
    history.replaceState(null, '', '#label=' + encodeURIComponent(text));
    search(text);
  });
  byId('word').addEventListener('change', () => byId('search').requestSubmit());
  [['rooms', 2], ['zones', 4]].forEach(([name, at]) => {
    if (byId(`by-${name}`)) byId(`by-${name}`).addEventListener('click', () => {
      paint(node => [fromHex(node[at]), node[at + 1]]);
      paintBadges(at);
      legend(name);
    });
  });
  function follow() {
    const [key, value] = location.hash.slice(1).split('=');
    if (key === 'label' && value !== undefined) {
      let text = value;
      try { text = decodeURIComponent(value); } catch (e) { /* a hash typed by hand */ }
      const line = data.labels.indexOf(text);  // a whole label line is that label and no other
      byId('word').value = text;
      if (line >= 0) { tell(shortName(line), [[line, 1]]); showLabel(line); } else search(text);
    } else if (key === 'select') select(+value);
    else if (byId('smaller') && byId(location.hash.slice(1))) byId('smaller').open = true;
  }
  addEventListener('hashchange', follow);
  byId('words').append(...[...new Set(data.labels.map((_, label) => shortName(label)))].sort()
    .map(value => make('option', {value})));
  byId('search').hidden = false;
  follow();
})();
