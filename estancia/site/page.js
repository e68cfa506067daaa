// SPDX-License-Identifier: Apache-2.0
// The live page: what the robot sees and where it is, the map as it grows, search, ways, and corrections.
import {Plan} from './plan.js';
import {Panel, api, make, percent} from './panel.js';

const byId = id => document.getElementById(id);
let status = null, map = null, revision = -1, isLoading = false;

// A token in the address has become a cookie: it need not stay where others see it.
if (location.search) history.replaceState(null, '', location.pathname);

const plan = new Plan(byId('plan'), {
  area: (id, point) => panel.clickedArea(id, point),
  object: id => panel.showObject(id),
  place: node => panel.showPlace(node),
  floor: point => panel.clickedFloor(point)
});
const panel = new Panel(byId('found'), plan, {
  map: () => map,
  hint: text => { byId('map-hint').textContent = text; },
  isPlaced: () => Boolean(status && status.where.place),
  changed: () => loadMap()
});

// ---- connection
let lost = null;
function say(text, isGood) {
  const line = make('p', {textContent: text, className: isGood ? 'good' : ''});
  byId('alerts').append(line);
  return line;
}
function connected(isConnected) {
  if (!isConnected && !lost) {
    lost = say('The connection is lost. What you see is from before; trying again …');
    showState();
  } else if (isConnected && lost) {
    lost.remove();
    lost = null;
    const line = say('Connected again.', true);
    setTimeout(() => line.remove(), 4000);
    showState();
  }
}
let events = null;
function listen() {
  events = new EventSource('/api/events');
  events.onopen = () => { connected(true); loadMap(); };
  events.addEventListener('status', event => { connected(true); show(JSON.parse(event.data)); });
  events.onerror = () => {
    connected(false);
    if (events.readyState !== EventSource.CLOSED) return;  // it tries by itself
    setTimeout(() => { if (events && !document.hidden) listen(); }, 2000);
  };
}
// a page that nobody sees costs the robot nothing
document.addEventListener('visibilitychange', () => {
  if (document.hidden && events) {
    events.close();
    events = null;
  } else if (!document.hidden && !events) {
    listen();
  }
});

// ---- now
const states = {mapping: 'Mapping', localizing: 'Localizing', waiting: 'Waiting for images', ended: 'The drive has ended'};
function showState() {
  const element = byId('state');
  const isAtRest = status && status.state === 'ended' && !status.frames;
  element.className = lost ? 'lost' : !status ? '' : status.state === 'waiting' ? 'waiting' : status.state === 'ended' ? '' : 'live';
  const rate = status && status.rate > 0 && (status.state === 'mapping' || status.state === 'localizing')
    ? ` · ${status.rate.toFixed(status.rate < 10 ? 1 : 0)} images/s` : '';
  element.lastElementChild.textContent = lost ? 'Not connected' : !status ? 'Connecting …'
    : isAtRest ? 'Map at rest' : (states[status.state] || status.state) + rate;
}
function showTroubles() {
  byId('alerts').querySelectorAll('.trouble').forEach(line => line.remove());
  status.troubles.forEach(text => say(text).classList.add('trouble'));
}
function bars(words) {
  return words.map(({label, probability}) => {
    const bar = make('i', {});
    bar.style.width = `${100 * probability}%`;
    return make('li', {}, make('span', {className: 'label', textContent: label.split(',')[0], title: label}),
      make('span', {className: 'bar'}, bar), make('span', {className: 'p', textContent: percent(probability)}));
  });
}
function showWhere(where) {
  const name = where.area ? where.area.name : where.place ? where.place.name || `Place ${where.place.node}` : 'Not known yet';
  const parts = [];
  if (where.place) parts.push(`place ${where.place.node}`);
  if (where.room && where.room !== name) parts.push(where.room);
  if (where.pose) parts.push(`(${where.pose.x.toFixed(1)}, ${where.pose.y.toFixed(1)}) m`);
  if (where.unmapped !== null && where.unmapped > 0.5) parts.push(`probably nowhere on the map (${percent(where.unmapped)})`);
  byId('where-name').textContent = name;
  byId('where-detail').textContent = parts.join(' · ');
  byId('sure').hidden = !where.place;
  if (!where.place) return;
  byId('sure').querySelector('i').style.width = `${100 * where.place.probability}%`;
  byId('sure').querySelector('.p').textContent = percent(where.place.probability);
}
function showPace() {
  const {latency} = status, parts = [];
  if (status.frames) parts.push(`${status.frames.toLocaleString('en')} images`);
  if (status.dropped) parts.push(`${status.dropped.toLocaleString('en')} passed over for newer ones`);
  if (status.failed) parts.push(`${status.failed.toLocaleString('en')} not usable`);
  if (latency.median) parts.push(`${latency.median.toFixed(0)} ms from image to place (95 %: ${latency.p95.toFixed(0)} ms)`);
  byId('pace').textContent = parts.join(' · ');
}
const frame = byId('frame');
let frameShown = -1, isFrameLoading = false;
function showFrame() {
  if (isFrameLoading || !status.where.frame || frameShown === status.revision) return;
  isFrameLoading = true;
  frameShown = status.revision;
  const next = new Image();
  const done = isThere => {
    isFrameLoading = false;
    frame.hidden = !isThere;
    if (isThere) frame.src = next.src;
    if (status.revision !== frameShown) setTimeout(showFrame, 60);
  };
  next.onload = () => done(true);
  next.onerror = () => done(false);
  next.src = `/api/frame.jpg?revision=${status.revision}`;
}
function show(newest) {
  status = newest;
  byId('source').textContent = status.source;
  document.title = status.where.area ? `${status.where.area.name} · Estancia` : 'Estancia';
  showState();
  showTroubles();
  byId('now').hidden = !status.where.frame && !status.where.place;
  showWhere(status.where);
  byId('now-words').replaceChildren(...bars(status.words.slice(0, 5)));
  byId('decision').textContent = status.decision || '';
  showPace();
  showFrame();
  plan.setRobot(status.where);
  if (status.map_revision !== revision) loadMap();
}

// ---- the map
let loadedAt = 0, again = 0;
async function loadMap() {
  const wait = 700 - (Date.now() - loadedAt);  // it may change with each image
  if (isLoading || wait > 0) {
    if (!again) again = setTimeout(() => { again = 0; loadMap(); }, Math.max(wait, 100));
    return;
  }
  isLoading = true;
  try {
    map = await api('/api/map');
    revision = map.map_revision;
    showMap();
  } catch (problem) {
    if (problem.code !== 'insufficient-data' && !lost) console.info(problem.message);
  } finally {
    isLoading = false;
    loadedAt = Date.now();
  }
}
function showMap() {
  const isEmpty = !map.places.length;
  byId('empty').hidden = !isEmpty;
  byId('plan').style.display = isEmpty ? 'none' : '';
  if (!isEmpty) plan.show(map);
  panel.mapChanged();
  byId('lists').hidden = !map.areas.length && map.drives < 2;
  byId('changes').hidden = map.drives < 2;
  byId('areas').replaceChildren(...map.areas.map(area => {
    const tint = make('i', {className: 'tint'});
    tint.style.background = area.color;
    const button = make('button', {type: 'button'}, tint, make('span', {textContent: area.name}),
      make('small', {textContent: `${area.size.toFixed(1)} m²`}));
    button.addEventListener('click', () => panel.showArea(area.id, true));
    return make('li', {}, button);
  }));
}

byId('changes').addEventListener('click', () => panel.showChanges());

// ---- search
byId('search').addEventListener('submit', event => {
  event.preventDefault();
  const words = byId('word').value.trim();
  if (words) panel.search(words);
  else panel.clear();
});
byId('word').addEventListener('search', () => { if (!byId('word').value) panel.clear(); });
addEventListener('keydown', event => {
  if (event.key === 'Escape') panel.clear();
  if (event.key === '/' && !/^(INPUT|TEXTAREA)$/.test(document.activeElement.tagName)) {
    event.preventDefault();
    byId('word').focus();
  }
});

listen();
