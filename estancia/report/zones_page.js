// SPDX-License-Identifier: Apache-2.0
// One zone alone: everything that shows a zone carries its number as data-zone. Without this script the same
// links lead to the zone's card.
(() => {
  'use strict';
  const main = document.querySelector('main'), side = document.querySelector('.side .panel');
  if (!side) return;
  const shown = [...document.querySelectorAll('[data-zone]')];
  const status = document.createElement('p');
  status.id = 'chosen';
  status.setAttribute('aria-live', 'polite');
  side.querySelector('h2').after(status);

  function choose(zone) {
    const card = zone === null ? null : document.getElementById(`zone-${zone}`);
    shown.forEach(element => element.classList.toggle('selected', element.dataset.zone === zone));
    document.querySelectorAll('article').forEach(element => element.classList.toggle('selected', element === card));
    main.classList.toggle('chosen', zone !== null);
    status.replaceChildren();
    if (zone === null) return;
    const link = document.createElement('a');
    link.href = `#zone-${zone}`;
    link.textContent = 'details';
    const all = document.createElement('button');
    all.type = 'button';
    all.textContent = 'Show all';
    all.onclick = () => { history.replaceState(null, '', '#map'); choose(null); };
    status.append(`Only zone ${zone} · `, link, all);
  }

  document.addEventListener('click', event => {
    const link = event.target.closest && event.target.closest('#map [data-zone]');
    if (!link) return;
    event.preventDefault();
    const zone = link.classList.contains('selected') ? null : link.dataset.zone;
    history.replaceState(null, '', zone === null ? '#map' : `#zone-${zone}`);
    choose(zone);
  });
  addEventListener('keydown', event => { if (event.key === 'Escape') choose(null); });
  function follow() {
    const found = /^#zone-(\d+)$/.exec(location.hash);
    if (!found) return;
    choose(found[1]);
    const card = document.getElementById(`zone-${found[1]}`);
    if (card && card.closest('details')) card.closest('details').open = true;
  }
  addEventListener('hashchange', follow);
  follow();
})();
