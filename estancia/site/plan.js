// SPDX-License-Identifier: Apache-2.0
// The map seen from above, drawn into an <svg>: areas, walls, places, objects, ways, the robot.
const space = 'http://www.w3.org/2000/svg';
const draw = (name, attributes = {}, ...children) => {
  const element = document.createElementNS(space, name);
  Object.entries(attributes).forEach(([key, value]) => element.setAttribute(key, value));
  element.append(...children);
  return element;
};
const titled = (element, text) => {
  element.append(Object.assign(draw('title'), {textContent: text}));
  element.setAttribute('aria-label', text);
  return element;
};

export class Plan {
  // events: {area(id, point), object(id), place(node), floor(point)}
  constructor(svg, events) {
    this.svg = svg;
    this.events = events;
    this.map = null;
    this.layers = {};
    this.marks = {areas: [], objects: [], places: []};
    svg.addEventListener('click', event => this.clicked(event));
    svg.addEventListener('keydown', event => {
      if (event.key !== 'Enter' && event.key !== ' ') return;
      event.preventDefault();
      this.clicked(event);
    });
    new ResizeObserver(() => this.map && this.width !== svg.clientWidth && this.show(this.map)).observe(svg);
  }

  clicked(event) {
    const target = event.target.closest('[data-kind]');
    const box = this.svg.getBoundingClientRect(), point = event.clientX || event.clientY
      ? this.onFloor([event.clientX - box.left, event.clientY - box.top]) : null;
    if (!target) return this.events.floor(point);
    this.events[target.dataset.kind](+target.dataset.id, point);
  }

  // ---- meters ↔ pixels
  fit() {
    const points = [];
    this.map.areas.forEach(a => a.outlines.forEach(line => points.push(...line)));
    [...this.map.walls, ...this.map.path].forEach(line => points.push(...line));
    this.map.places.forEach(p => p.position && points.push(p.position));
    this.map.objects.forEach(o => points.push(...o.box));
    const least = [0, 1].map(i => points.reduce((m, p) => Math.min(m, p[i]), Infinity));
    const most = [0, 1].map(i => points.reduce((m, p) => Math.max(m, p[i]), -Infinity));
    Object.assign(this, {least: [...least], most: [...most]});
    if (this.isNear()) [this.where.pose.x, this.where.pose.y].forEach((v, i) => { least[i] = Math.min(least[i], v); most[i] = Math.max(most[i], v); });
    const size = [0, 1].map(i => Math.max(points.length ? most[i] - least[i] : 0, 1));
    const margin = 22;
    this.width = this.svg.clientWidth || 600;
    const room = Math.max(260, Math.min(innerHeight * 0.74, this.width * 1.15));
    this.scale = Math.min((this.width - 2 * margin) / size[0], (room - 2 * margin) / size[1]);
    this.height = Math.round(size[1] * this.scale + 2 * margin);
    this.middle = points.length ? [0, 1].map(i => (least[i] + most[i]) / 2) : [0, 0];
    this.svg.setAttribute('viewBox', `0 0 ${this.width} ${this.height}`);
  }
  // a robot drives on before the map shows it; one that is lost is left out
  isNear() {
    const pose = this.map.metric && this.where && this.where.pose;
    const extent = Math.max(this.most[0] - this.least[0], this.most[1] - this.least[1], 2);
    return Boolean(pose) && [pose.x, pose.y].every((v, i) => v > this.least[i] - extent && v < this.most[i] + extent);
  }
  isInView({x, y}) {
    const [column, row] = this.at([x, y]);
    return column >= 0 && row >= 0 && column <= this.width && row <= this.height;
  }
  at([x, y]) {
    return [this.width / 2 + this.scale * (x - this.middle[0]), this.height / 2 - this.scale * (y - this.middle[1])];
  }
  onFloor([x, y]) {
    return [(x - this.width / 2) / this.scale + this.middle[0], (this.height / 2 - y) / this.scale + this.middle[1]];
  }
  line(points, close = '') {
    return points.length ? 'M' + points.map(p => this.at(p).map(v => v.toFixed(1)).join(' ')).join('L') + close : '';
  }
  outline(lines) { return lines.map(line => this.line(line, 'Z')).join(''); }

  // ---- the map
  show(map) {
    const focused = document.activeElement && document.activeElement.closest('#plan [data-kind]');
    this.map = map;
    this.fit();
    const names = ['areas', 'walls', 'path', 'links', 'boxes', 'places', 'belief', 'things', 'way', 'robot', 'names', 'cut'];
    names.forEach(name => { this.layers[name] = draw('g', {class: name}); });
    this.drawAreas();
    this.layers.walls.append(draw('path', {class: 'walls', 'fill-rule': 'evenodd', d: this.outline(map.walls)}));
    map.path.forEach(line => this.layers.path.append(draw('path', {class: 'driven', d: this.line(line)})));
    this.drawPlaces();
    this.drawObjects();
    this.drawScale();
    this.svg.replaceChildren(...names.map(name => this.layers[name]));
    this.drawNames();
    this.drawRobot();
    this.drawWay();
    this.drawCut();
    this.applyMarks();
    if (focused) this.find(focused.dataset.kind, focused.dataset.id)?.focus();
  }
  find(kind, id) { return this.svg.querySelector(`[data-kind="${kind}"][data-id="${id}"]`); }
  button(kind, id, text, attributes) {
    return titled(draw('g', {role: 'button', tabindex: 0, 'data-kind': kind, 'data-id': id, ...attributes}), text);
  }
  drawAreas() {
    this.map.areas.forEach(area => {
      const group = this.button('area', area.id, `${area.name}, ${area.size.toFixed(1)} m²`, {class: 'area'});
      group.append(draw('path', {fill: area.color, stroke: area.color, 'fill-rule': 'evenodd', d: this.outline(area.outlines)}));
      this.layers.areas.append(group);
    });
  }
  drawPlaces() {
    const positions = new Map(this.map.places.filter(p => p.position).map(p => [p.node, this.at(p.position)]));
    const isBare = !this.map.areas.length;
    this.map.links.forEach(([a, b]) => {
      const from = positions.get(a), to = positions.get(b);
      if (from && to) this.layers.links.append(draw('line', {class: 'link', x1: from[0], y1: from[1], x2: to[0], y2: to[1]}));
    });
    this.map.places.forEach(place => {
      const at = positions.get(place.node);
      if (!at) return;
      const name = place.name ? `, ${place.name}` : '';
      const group = this.button('place', place.node, `Place ${place.node}${name}`, {class: 'spot'});
      group.append(draw('circle', {cx: at[0], cy: at[1], r: isBare ? 10 : 4}));
      if (isBare) group.append(Object.assign(draw('text', {x: at[0], y: at[1] + 3.5}), {textContent: place.node}));
      this.layers.places.append(group);
    });
  }
  drawObjects() {
    this.map.objects.forEach(object => {
      this.layers.boxes.append(draw('path', {class: 'box', d: this.line(object.box, 'Z')}));
      const [x, y] = this.at(object.at), where = object.where ? `, ${object.where}` : '';
      const group = this.button('object', object.id, object.name + where, {class: 'thing'});
      group.append(draw('circle', {class: 'finger', cx: x, cy: y, r: 11}),
        draw('circle', {class: 'dot', cx: x, cy: y, r: 4.5, fill: object.color}));
      this.layers.things.append(group);
    });
  }
  drawScale() {
    if (!this.map.metric) return;
    const meters = [0.5, 1, 2, 5, 10, 20, 50, 100].find(m => m * this.scale >= 40) || 200, width = meters * this.scale;
    const y = this.height - 8;
    this.layers.names.append(draw('path', {class: 'scale', d: `M10 ${y - 5}V${y}H${10 + width}V${y - 5}`}),
      Object.assign(draw('text', {class: 'scale-text', x: 16 + width, y}), {textContent: `${meters} m`}));
  }
  // names in the middle of their areas, as much of them as fits; none over another
  drawNames() {
    const boxes = [];
    const put = (text, [middle, y]) => {
      const width = 7.6 * text.length, x = Math.min(Math.max(middle, width / 2 + 4), Math.max(this.width - width / 2 - 4, width / 2 + 4));
      for (const shift of [0, -17, 17]) {
        const box = [x - width / 2, y + shift - 9, x + width / 2, y + shift + 9];
        if (boxes.some(b => box[0] < b[2] && b[0] < box[2] && box[1] < b[3] && b[1] < box[3])) continue;
        boxes.push(box);
        this.layers.names.append(Object.assign(draw('text', {class: 'area-name', x, y: y + shift + 5, 'text-anchor': 'middle'}), {textContent: text}));
        return;
      }
    };
    this.map.areas.forEach(area => {
      const xs = area.outlines.flat().map(p => this.at(p)[0]);
      if (!xs.length) return;
      const letters = Math.floor((Math.max(...xs) - Math.min(...xs)) / 7.6);
      const words = area.name.split(', ');
      while (words.length > 1 && words.join(', ').length > letters) words.pop();
      const text = words.join(', ');
      put(text.length <= letters ? text : `${text.slice(0, Math.max(letters - 1, 3))}…`, this.at(area.center));
    });
  }

  // ---- what changes more often than the map
  // where: as /api/where
  setRobot(where) {
    this.where = where;
    if (!this.map) return;
    if (this.isNear() && !this.isInView(where.pose)) this.show(this.map);
    else this.drawRobot();
  }
  drawRobot() {
    const {where, layers} = this;
    layers.robot.replaceChildren();
    layers.belief.replaceChildren();
    if (!where) return;
    const here = where.place && where.place.node;
    this.layers.places.querySelectorAll('.spot').forEach(spot => spot.classList.toggle('is-here', +spot.dataset.id === here));
    const positions = new Map(this.map.places.map(p => [p.node, p.position]));
    where.belief.forEach(({node, probability}) => {
      const position = positions.get(node);
      if (!position || probability < 0.02) return;
      const [cx, cy] = this.at(position);
      layers.belief.append(draw('circle', {cx, cy, r: 8 + 14 * Math.sqrt(probability), 'fill-opacity': (0.28 * probability).toFixed(3)}));
    });
    if (!where.pose || !this.map.metric) return;
    const [x, y] = this.at([where.pose.x, where.pose.y]), turn = -where.pose.yaw * 180 / Math.PI;
    layers.robot.append(draw('g', {class: 'robot', transform: `translate(${x.toFixed(1)} ${y.toFixed(1)}) rotate(${turn.toFixed(1)})`},
      draw('path', {class: 'cone', d: 'M0 0L38 -22A44 44 0 0 1 38 22Z'}),
      draw('path', {class: 'body', d: 'M12 0L-8 8L-4 0L-8 -8Z'})));
  }
  // route: as /api/route; null for none
  setWay(route) {
    this.route = route;
    if (this.map) this.drawWay();
  }
  drawWay() {
    const {route, layers} = this;
    layers.way.replaceChildren();
    if (!route) return;
    const positions = new Map(this.map.places.map(p => [p.node, p.position]));
    const points = route.driven ? route.driven.path : route.nodes.map(node => positions.get(node)).filter(Boolean);
    if (points.length > 1) ['under', 'over'].forEach(kind => layers.way.append(draw('path', {class: kind, d: this.line(points)})));
    if (points.length) {
      const [cx, cy] = this.at(points[0]);
      layers.way.append(draw('g', {class: 'start'}, draw('circle', {cx, cy, r: 5})));
    }
    if (!route.pose) return;
    const {x, y, yaw, distance} = route.pose, [px, py] = this.at([x, y]);
    layers.way.append(
      draw('path', {class: 'look', d: this.line([[x, y], [x + distance * Math.cos(yaw), y + distance * Math.sin(yaw)]])}),
      draw('path', {class: 'stand', d: 'M13 0L-8 8L-4 0L-8 -8Z',
        transform: `translate(${px.toFixed(1)} ${py.toFixed(1)}) rotate(${(-yaw * 180 / Math.PI).toFixed(1)})`}));
  }
  // ends: [[x, y], …] of a line to split along
  setCut(ends) {
    this.cut = ends;
    if (this.map) this.drawCut();
  }
  drawCut() {
    const ends = (this.cut || []).map(end => this.at(end));
    this.layers.cut.replaceChildren();
    if (ends.length === 2)
      this.layers.cut.append(draw('line', {class: 'cut', x1: ends[0][0], y1: ends[0][1], x2: ends[1][0], y2: ends[1][1]}));
    ends.forEach(([cx, cy]) => this.layers.cut.append(draw('circle', {class: 'cut-end', cx, cy, r: 5})));
  }

  // what is highlighted; `chosen`: [kind, id] of the one that is shown in the panel
  mark({areas = [], objects = [], places = [], chosen = []}) {
    this.marks = {areas, objects, places, chosen};
    if (this.map) this.applyMarks();
  }
  applyMarks() {
    const {areas, objects, places, chosen = []} = this.marks;
    this.svg.classList.toggle('asked', objects.length > 0);
    const of = {area: new Set(areas), object: new Set(objects), place: new Set(places)};
    this.svg.querySelectorAll('[data-kind]').forEach(element => {
      const {kind, id} = element.dataset;
      element.classList.toggle('on', of[kind].has(+id));
      element.classList.toggle('chosen', kind === chosen[0] && +id === chosen[1]);
    });
  }
  pick(isPicking) { this.svg.classList.toggle('picking', isPicking); }
}
